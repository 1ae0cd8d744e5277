#include "viewer/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"

namespace scanmill {

Rgb mix(const Rgb& a, const Rgb& b, double t) {
  Rgb out{};
  for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::lround(a[c] + (b[c] - a[c]) * t));
  return out;
}

void fillRectangle(Image& image, int x, int y, int width, int height, const Rgb& color) {
  const int left = std::clamp(x, 0, image.width);
  const int right = std::clamp(x + width, left, image.width);
  for (int row = std::max(y, 0); row < std::min(y + height, image.height); ++row) {
    if (right > left) std::fill_n(&image.at(left, row), right - left, color);
  }
}

void paste(Image& image, const Image& source, int x, int y) {
  for (int row = 0; row < source.height; ++row) {
    for (int column = 0; column < source.width; ++column) {
      if (image.contains(x + column, y + row)) image.at(x + column, y + row) = source.at(column, row);
    }
  }
}

std::string encodePng(const Image& image) {
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("png");
  if (!out) throw Error(fmt::format("no PNG writer: {}", OIIO::geterror()));
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("png:compressionLevel", 9);
  spec.attribute("png:filter", 8);  // none: splats have no gradients, and become a quarter smaller without
  spec.attribute("DateTime", "1970:01:01 00:00:00");  // else the writer takes the clock
  if (!out->set_ioproxy(&memory) || !out->open("picture.png", spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, image.pixels.data()) || !out->close()) {
    throw Error(fmt::format("the PNG could not be encoded: {}", out->geterror()));
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace scanmill
