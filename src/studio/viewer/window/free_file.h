#pragma once

#include <filesystem>
#include <string>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// `name`_000`suffix` in the current folder, or the next number that is free. Throws Error.
std::filesystem::path freeFile(const std::string& name, const std::string& suffix);

// Writes what was last drawn to such a file. Throws Error.
std::filesystem::path savePictureOf(Canvas& canvas);

}  // namespace scanmill
