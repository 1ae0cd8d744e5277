#pragma once

#include <memory>
#include <string_view>

#include "images/images_interface.h"

namespace scanmill {

// Opens a JPEG and reads its header. The caller must keep the bytes as long as the reader. Returns null for an image of
// four inks (CMYK), which OpenImageIO must convert. Throws std::runtime_error with libjpeg's message if the file is
// damaged, or if libjpeg warns of anything that may change the pixels.
std::unique_ptr<ImageReader> openJpeg(std::string_view bytes);

}  // namespace scanmill
