#pragma once

#include <memory>
#include <string_view>

#include "images/images_interface.h"

namespace scanmill {

// Opens a PNG, which the caller keeps as long as the reader, and reads its header. libpng would write about damage to
// standard error, where others call it; here what it says is thrown as std::runtime_error. Colours are as stored:
// profiles and gamma are not applied.
std::unique_ptr<ImageReader> openPng(std::string_view bytes);

}  // namespace scanmill
