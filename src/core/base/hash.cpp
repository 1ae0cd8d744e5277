#include "base/hash.h"

#include <fmt/core.h>
#include <openssl/evp.h>

#include <algorithm>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

namespace {

// Largest number of groups (three bytes, or four letters) per call, since OpenSSL counts bytes in an int.
constexpr std::size_t kGroups = std::size_t{1} << 20;

const unsigned char* asBytes(const char* text) {
  return reinterpret_cast<const unsigned char*>(text);
}

}  // namespace

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  if (EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) != 1)
    throw Error("SHA-256 is not available in OpenSSL");
}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::add(std::string_view bytes) {
  if (EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) != 1) throw Error("SHA-256 failed in OpenSSL");
}

std::string Sha256::hex() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_DigestFinal_ex(state_->context, digest, &size) != 1) throw Error("SHA-256 failed in OpenSSL");
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hex();
}

std::string xxh3(std::string_view bytes) {
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

std::string xxh3OfFile(const std::filesystem::path& file) {
  XXH3_state_t state;
  XXH3_64bits_reset(&state);
  readBlocks(file, [&](std::string_view block) { XXH3_64bits_update(&state, block.data(), block.size()); });
  return fmt::format("{:016x}", XXH3_64bits_digest(&state));
}

std::string sha256OfFile(const std::filesystem::path& file) {
  Sha256 hash;
  readBlocks(file, [&](std::string_view block) { hash.add(block); });
  return hash.hex();
}

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
