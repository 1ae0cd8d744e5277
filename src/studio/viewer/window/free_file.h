#pragma once

#include <filesystem>
#include <string>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// Returns `name`_000`suffix` in the current folder, with the first number that no file has yet. Throws Error.
std::filesystem::path freeFile(const std::string& name, const std::string& suffix);

// Writes the last picture drawn to a file named by freeFile(). Throws Error.
std::filesystem::path savePictureOf(Canvas& canvas);

}  // namespace scanmill
