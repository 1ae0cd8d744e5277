#pragma once

#include <memory>
#include <string_view>

#include "images/images_interface.h"

namespace scanmill {

// Opens a JPEG, which the caller keeps as long as the reader, and reads its header. Returns null for an image of four
// inks (CMYK), which OpenImageIO converts. Damage is thrown as std::runtime_error in libjpeg's words, and so is what
// libjpeg only warns of, unless the pixels are the same without it.
std::unique_ptr<ImageReader> openJpeg(std::string_view bytes);

}  // namespace scanmill
