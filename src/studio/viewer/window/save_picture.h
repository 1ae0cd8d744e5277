#pragma once

#include <filesystem>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// Writes the last picture drawn to scanmill_view_000.png in the current folder, or to the first number that no file has
// yet; returns the file. Throws Error.
std::filesystem::path savePictureOf(Canvas& canvas);

}  // namespace scanmill
