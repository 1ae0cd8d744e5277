#pragma once

// The readers of PNG and JPEG. The caller must keep the bytes of an image as long as its reader.

#include <memory>
#include <string_view>

#include "images/images_interface.h"

namespace scanmill {

// Opens a PNG and reads its header. Throws std::runtime_error with libpng's message if the file is damaged. Colours are
// returned as stored: profiles and gamma are not applied, as glTF demands.
std::unique_ptr<ImageReader> openPng(std::string_view bytes);

// Opens a JPEG and reads its header. Returns null for an image of four inks (CMYK), which OpenImageIO must convert.
// Throws std::runtime_error with libjpeg's message if the file is damaged, or if libjpeg warns of anything that may
// change the pixels.
std::unique_ptr<ImageReader> openJpeg(std::string_view bytes);

}  // namespace scanmill
