#pragma once

#include <string>

#include "viewer/image.h"

namespace scanmill {

// Writes scanmill_view_000.png, or the next number that is free, to the current folder; its path. Throws Error.
std::string saveViewPicture(const Image& image);

}  // namespace scanmill
