#include "images/png_chunks.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/error.h"

namespace scanmill {

namespace {

// CRC-32 of PNG chunks (ISO 3309).
std::uint32_t crc(std::string_view bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> out{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      out[i] = i;
      for (int bit = 0; bit < 8; ++bit) out[i] = (out[i] & 1) != 0 ? 0xEDB88320 ^ (out[i] >> 1) : out[i] >> 1;
    }
    return out;
  }();
  std::uint32_t value = 0xFFFFFFFF;
  for (const char c : bytes) value = table[(value ^ static_cast<std::uint8_t>(c)) & 255] ^ (value >> 8);
  return ~value;
}

std::uint32_t bigEndian(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return word;
}

}  // namespace

std::string plainPng(std::string_view bytes, const std::string& name) {
  constexpr std::array<std::string_view, 5> kKept{"IHDR", "PLTE", "tRNS", "IDAT", "IEND"};
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
  if (bytes.size() >= kSignature.size() && !bytes.starts_with(kSignature)) {
    throw InputError({name}, "the PNG is damaged");
  }
  std::string out(bytes.substr(0, kSignature.size()));
  for (std::size_t at = kSignature.size(); bytes.size() >= at + 12;) {
    const std::size_t size = bigEndian(bytes, at);
    if (size > bytes.size() - at - 12) break;
    const std::string_view kind = bytes.substr(at + 4, 4);
    if (crc(bytes.substr(at + 4, size + 4)) != bigEndian(bytes, at + 8 + size)) {
      throw InputError({name}, "the PNG is damaged");
    }
    if (std::find(kKept.begin(), kKept.end(), kind) != kKept.end()) out += bytes.substr(at, size + 12);
    at += size + 12;
    if (kind == "IEND") return out;
  }
  throw InputError({name}, "the PNG is truncated");
}

}  // namespace scanmill
