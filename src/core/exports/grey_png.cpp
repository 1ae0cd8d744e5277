// Portable Network Graphics (w3.org/TR/png): chunks of a length, a type, data and a CRC-32, the numbers with the most
// significant byte first.

#include "exports/grey_png.h"

#include <fmt/core.h>
#include <zlib.h>

#include "base/error.h"
#include "exports/little_endian.h"

namespace scanmill {

namespace {

void putBigEndian(std::uint32_t value, std::string& bytes) {
  std::string little;
  putNumber(value, little);
  bytes.append(little.rbegin(), little.rend());
}

void putChunk(const char* type, const std::string& data, std::string& png) {
  const std::string covered = type + data;  // by the CRC
  putBigEndian(static_cast<std::uint32_t>(data.size()), png);
  png += covered;
  putBigEndian(static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(covered.data()), covered.size())),
               png);
}

}  // namespace

std::string greyPng(std::span<const std::uint8_t> pixels, std::uint32_t width) {
  std::string header;
  putBigEndian(width, header);
  putBigEndian(static_cast<std::uint32_t>(pixels.size() / width), header);
  header += std::string("\x08\x00\x00\x00\x00", 5);  // bits, grey, deflate, the usual filters, not interlaced
  std::string rows;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (i % width == 0) rows += '\0';  // the row is not filtered
    rows += static_cast<char>(pixels[i]);
  }
  std::string packed(compressBound(static_cast<uLong>(rows.size())), '\0');
  auto size = static_cast<uLongf>(packed.size());
  const int state = compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                             reinterpret_cast<const Bytef*>(rows.data()), static_cast<uLong>(rows.size()));
  if (state != Z_OK) throw Error(fmt::format("zlib cannot deflate an image: {}", zError(state)));
  packed.resize(size);
  std::string png = "\x89PNG\r\n\x1a\n";
  putChunk("IHDR", header, png);
  putChunk("IDAT", packed, png);
  putChunk("IEND", "", png);
  return png;
}

}  // namespace scanmill
