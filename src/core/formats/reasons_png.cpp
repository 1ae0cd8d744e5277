#include "formats/reasons_png.h"

#include <fmt/core.h>
#include <png.h>

#include <array>
#include <map>

#include "base/error.h"
#include "scan/reasons.h"

namespace scanmill {

std::string encodeReasons(const std::vector<std::uint8_t>& reasonOfBeam, std::uint32_t rings, std::uint32_t columns) {
  if (reasonOfBeam.size() != std::size_t{rings} * columns) {
    throw Error("{} reasons for {} x {} beams", reasonOfBeam.size(), rings, columns);
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = columns;
  image.height = rings;
  image.format = PNG_FORMAT_RGB_COLORMAP;
  constexpr std::size_t kMostReason = 31;  // largest value with an entry in the palette
  image.colormap_entries = kMostReason + 1;
  std::array<std::array<std::uint8_t, 3>, kMostReason + 1> colors{};
  for (const ReasonEntry& row : reasons()) colors[static_cast<std::size_t>(row.reason)] = row.color;
  std::string bytes(mostReasonsBytes(rings, columns), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, reasonOfBeam.data(), 0, colors.data()) == 0) {
    throw Error("reasons cannot be written as a PNG: {}", image.message);
  }
  bytes.resize(size);
  return bytes;
}

ReasonsImage decodeReasons(std::string_view bytes, const std::string& what) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto refuse = [&](std::string_view reason) { throw InputError({what}, "is no image of reasons: {}", reason); };
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) refuse(image.message);
  if (image.width > 65536 || image.height > 65536) {
    png_image_free(&image);
    refuse(fmt::format("it has {} x {} pixels", image.width, image.height));
  }
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0) refuse(image.message);
  std::map<std::array<std::uint8_t, 3>, std::uint8_t> values;
  for (const ReasonEntry& row : reasons()) values.emplace(row.color, static_cast<std::uint8_t>(row.reason));
  ReasonsImage result{.rings = image.height, .columns = image.width, .reasonOfBeam = {}};
  for (std::size_t i = 0; i < pixels.size() / 3; ++i) {
    const auto value = values.find({pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2]});
    if (value == values.end()) refuse(fmt::format("pixel {} has a colour that stands for no reason", i));
    result.reasonOfBeam.push_back(value->second);
  }
  return result;
}

std::uint64_t mostReasonsBytes(std::uint32_t rings, std::uint32_t columns) {
  const std::uint64_t plain = std::uint64_t{rings} * (columns + 1);
  return plain + plain / 100 + 4096;  // deflate adds little to data that it cannot compress
}

}  // namespace scanmill
