#pragma once

// Reads and writes images: PNG by libpng, JPEG by libjpeg, all other kinds by OpenImageIO, which brings hundreds of
// shared libraries. Its module (images/images_interface.h) is therefore loaded at its first use, from any thread. If it
// cannot be loaded, functions that need it throw an Error that says how to install it.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/format_support.h"

namespace scanmill {

// The contents of images that are read or left out.
extern const FormatSupport kImageFormat;

// 8-bit RGBA in sRGB, top row first. Colours are not multiplied by alpha.
struct DecodedImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool hasAlpha = false;           // true: a pixel has an alpha below 255
  bool linear = false;             // true: the file has linear light
  std::vector<std::uint8_t> rgba;  // width * height * 4
};

// Decodes an image of a kind in kImageFormat. `name` names the image in messages; its ending tells the kind if the
// bytes do not show it. An image that is wider or higher than 4096 pixels is reduced to at most 4096 by averaging
// squares of pixels: on a wall of 40 m a pixel is then 1 cm wide, like a beam. Warns of what is left out. Throws an
// InputError that starts with the name if the bytes are no image or are damaged, or if the image is too large.
DecodedImage decodeImage(std::string_view bytes, const std::string& name);

// Reads and decodes a file as decodeImage() does. Throws InputError also if the file does not exist.
DecodedImage readImage(const std::filesystem::path& path);

// True if the file's header states an alpha channel, or if the header cannot be read.
bool mayHaveAlpha(const std::filesystem::path& path);

// Encodes 8-bit RGB (3 * width * height bytes, top row first) as a PNG. The same pixels always give the same bytes,
// since no time is stored.
std::string encodePng(const std::uint8_t* rgb, int width, int height);

}  // namespace scanmill
