#pragma once

// Reads and writes images: PNG by libpng, JPEG by libjpeg, all else by OpenImageIO. Its module
// (images/images_interface.h) is loaded when it is needed first, from any thread: it brings hundreds of shared
// libraries, and most scenes have no other image. Where it cannot be loaded, these functions throw an Error that says
// where images of other kinds can be read.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// 8 bit RGBA, the first row is the top one. Colours are not multiplied by alpha.
struct DecodedImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool hasAlpha = false;           // some pixel's is below 255
  std::vector<std::uint8_t> rgba;  // width * height * 4
};

// Decodes PNG, JPEG, WebP, TGA, SGI, BMP, TIFF, EXR and what else OpenImageIO knows; `name` stands for the bytes in
// messages, and its ending for their kind where they do not show it. An image of more than 4096 pixels in a row or
// column is reduced by a whole number to that, by the mean of its pixels: a wall of 40 m has a centimetre a pixel then,
// and beams are as wide. Throws InputError that starts with the name: not an image, damaged, truncated, wider or higher
// than 16384, or larger than its bytes or this process's memory can hold.
DecodedImage decodeImage(std::string_view bytes, const std::string& name);

// Does the same for a file. Throws InputError also where there is none.
DecodedImage readImage(const std::filesystem::path& path);

// Whether the file's header speaks of an alpha channel; true where the header cannot be read.
bool mayHaveAlpha(const std::filesystem::path& path);

// Makes a PNG of 8 bit RGB, 3 * width * height bytes, the top row first. The same pixels give the same bytes: no clock
// is written.
std::string encodePng(const std::uint8_t* rgb, int width, int height);

}  // namespace scanmill
