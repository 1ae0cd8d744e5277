#pragma once

#include <memory>
#include <string_view>

#include "images/images_interface.h"

namespace scanmill {

// Opens a PNG and reads its header. The caller must keep the bytes as long as the reader. Throws std::runtime_error
// with libpng's message if the file is damaged. Colours are returned as stored: profiles and gamma are not applied.
std::unique_ptr<ImageReader> openPng(std::string_view bytes);

}  // namespace scanmill
