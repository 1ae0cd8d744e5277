#include "passes/exr_zip.h"

#include <fmt/core.h>
#include <zlib.h>

#include <bit>
#include <cstring>
#include <stdexcept>

namespace scanmill {

namespace {

static_assert(std::endian::native == std::endian::little, "pixels are copied as the file has them");

// Adds eight bytes to eight others, without carries from byte to byte.
constexpr std::uint64_t addBytes(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kHigh = 0x8080808080808080;
  return ((a & ~kHigh) + (b & ~kHigh)) ^ ((a ^ b) & kHigh);
}

// OpenEXR stores each byte but the first as its difference to the one before, plus 128. Sums are made of eight bytes at
// a time; modulo 256, an even number of 128s is nothing and an odd one flips the top bit.
void undoDifferences(std::string& bytes) {
  constexpr std::uint64_t kFlip = 0x0080008000800080;
  char* const data = bytes.data();
  std::uint8_t before = 128;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word;
    std::memcpy(&word, data + i, sizeof word);
    word = addBytes(word, word << 8);
    word = addBytes(word, word << 16);
    word = addBytes(word, word << 32);
    word = addBytes(word ^ kFlip, before * 0x0101010101010101u);
    std::memcpy(data + i, &word, sizeof word);
    before = static_cast<std::uint8_t>(word >> 56);
  }
  for (; i < bytes.size(); ++i) {
    before = static_cast<std::uint8_t>(before + static_cast<std::uint8_t>(data[i]) - 128);
    data[i] = static_cast<char>(before);
  }
}

// The pixels of a line, plain: their bytes in order.
struct PlainLine {
  const char* bytes;
  std::uint32_t operator()(std::size_t i) const {
    std::uint32_t value;
    std::memcpy(&value, bytes + 4 * i, sizeof value);
    return value;
  }
};

// The pixels of a line whose even bytes lie in one half of the block and whose odd ones in the other.
struct SplitLine {
  const char* even;
  const char* odd;
  std::uint32_t operator()(std::size_t i) const {
    std::uint16_t a;
    std::uint16_t b;
    std::memcpy(&a, even + 2 * i, sizeof a);
    std::memcpy(&b, odd + 2 * i, sizeof b);
    const auto low = std::uint32_t{a};
    const auto high = std::uint32_t{b};
    return (low & 0xFF) | (high & 0xFF) << 8 | (low & 0xFF00) << 8 | (high & 0xFF00) << 16;
  }
};

template <class Line>
void store(const Line& line, std::size_t width, char* to, std::size_t stride) {
  if (stride == sizeof(std::uint32_t)) {  // known to the compiler, the loop becomes vector instructions
    for (std::size_t i = 0; i < width; ++i) {
      const std::uint32_t value = line(i);
      std::memcpy(to + i * sizeof value, &value, sizeof value);
    }
    return;
  }
  for (std::size_t i = 0; i < width; ++i) {
    const std::uint32_t value = line(i);
    std::memcpy(to + i * stride, &value, sizeof value);
  }
}

}  // namespace

void ZipDecoder::decode(std::string_view block, std::size_t first, std::size_t lines,
                        std::span<const ZipTarget> targets) {
  const std::size_t lineBytes = width_ * channels_ * sizeof(std::uint32_t);
  bytes_.resize(lines * lineBytes);
  // What does not shrink is stored as it is.
  const bool plain = block.size() == bytes_.size();
  if (!plain) {
    auto size = static_cast<uLongf>(bytes_.size());
    const int result = ::uncompress(reinterpret_cast<Bytef*>(bytes_.data()), &size,
                                    reinterpret_cast<const Bytef*>(block.data()), static_cast<uLong>(block.size()));
    if (result != Z_OK || size != bytes_.size()) {
      throw std::runtime_error(fmt::format("the pixels of row {} cannot be decompressed", first));
    }
    undoDifferences(bytes_);
  }
  const std::size_t half = bytes_.size() / 2;
  for (std::size_t line = 0; line < lines; ++line) {
    for (const ZipTarget& target : targets) {
      char* const to = static_cast<char*>(target.pixels) + (first + line) * width_ * target.stride;
      const std::size_t at = line * lineBytes + target.channel * width_ * sizeof(std::uint32_t);
      if (plain) {
        store(PlainLine{block.data() + at}, width_, to, target.stride);
      } else {
        store(SplitLine{bytes_.data() + at / 2, bytes_.data() + half + at / 2}, width_, to, target.stride);
      }
    }
  }
}

}  // namespace scanmill
