#include "base/base64.h"

#include <openssl/evp.h>

#include <algorithm>
#include <cstddef>

namespace scanmill {
namespace {

// Largest number of groups (three bytes, or four letters) per call, since OpenSSL counts bytes in an int.
constexpr std::size_t kGroups = std::size_t{1} << 20;

const unsigned char* asBytes(const char* text) {
  return reinterpret_cast<const unsigned char*>(text);
}

}  // namespace

std::string base64(std::string_view bytes) {
  std::string out((bytes.size() + 2) / 3 * 4 + 1, '\0');  // OpenSSL appends a zero byte
  std::size_t written = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 3 * kGroups) {
    const std::size_t count = std::min(bytes.size() - i, 3 * kGroups);
    written += static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data() + written),
                                                        asBytes(bytes.data() + i), static_cast<int>(count)));
  }
  out.resize(written);
  return out;
}

std::optional<std::string> fromBase64(std::string_view text) {
  // Refuses what OpenSSL would accept: it would skip white space at both ends and "-" at the end, and decode padding in
  // the middle as zeroes.
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1 || text.find_first_of("= \t\r\n-") != std::string_view::npos) return std::nullopt;
  std::string out(text.size() / 4 * 3 + 3, '\0');
  std::size_t written = 0;
  for (std::size_t i = 0; i < text.size(); i += 4 * kGroups) {
    std::string group(text.substr(i, 4 * kGroups));
    const std::size_t padding = (4 - group.size() % 4) % 4;
    group.append(padding, '=');
    const int count = EVP_DecodeBlock(reinterpret_cast<unsigned char*>(out.data() + written), asBytes(group.data()),
                                      static_cast<int>(group.size()));
    if (count < 0) return std::nullopt;
    written += static_cast<std::size_t>(count) - padding;
  }
  out.resize(written);
  return out;
}

}  // namespace scanmill
