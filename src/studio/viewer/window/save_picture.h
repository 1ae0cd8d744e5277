#pragma once

#include <filesystem>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// Writes the picture that was drawn last to scanmill_view_000.png in the current folder, or to the file with the first
// number that is not used yet. Returns the file. Throws Error.
std::filesystem::path savePictureOf(Canvas& canvas);

}  // namespace scanmill
