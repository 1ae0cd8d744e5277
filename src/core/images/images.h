#pragma once

// Reads and writes images: PNG by libpng, JPEG by libjpeg, all other kinds by OpenImageIO. The module of OpenImageIO
// (images/images_interface.h) is loaded at its first use, from any thread, since it brings hundreds of shared libraries
// and most scenes have only PNG and JPEG. If it cannot be loaded, these functions throw an Error that says how to get
// it.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// 8-bit RGBA, top row first. Colours are not multiplied by alpha.
struct DecodedImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool hasAlpha = false;           // the alpha of some pixel is below 255
  std::vector<std::uint8_t> rgba;  // width * height * 4
};

// Decodes PNG, JPEG, WebP, TGA, SGI, BMP, TIFF, EXR and all other kinds that OpenImageIO knows. `name` stands for the
// bytes in messages; its ending gives the kind if the bytes do not show it. An image of more than 4096 pixels in a row
// or column is reduced to at most 4096 by a whole factor, as the mean of pixels: on a wall of 40 m a pixel then has a
// width of 1 cm, about that of a beam. Throws an InputError that starts with the name if the bytes are not an image,
// damaged or truncated, or if the image is wider or higher than 16384 pixels or larger than its bytes or this process's
// memory can hold.
DecodedImage decodeImage(std::string_view bytes, const std::string& name);

// Reads and decodes a file in the same way. Throws InputError also if the file does not exist.
DecodedImage readImage(const std::filesystem::path& path);

// True if the file's header states an alpha channel, or if the header cannot be read.
bool mayHaveAlpha(const std::filesystem::path& path);

// Encodes 8-bit RGB (3 * width * height bytes, top row first) as a PNG. The same pixels give the same bytes: no time is
// stored.
std::string encodePng(const std::uint8_t* rgb, int width, int height);

}  // namespace scanmill
