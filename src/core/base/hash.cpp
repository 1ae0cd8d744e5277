#include "base/hash.h"

#include <fmt/core.h>
#include <openssl/evp.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

namespace {

// Returns the size of `text` as an int, which OpenSSL takes. Throws Error if the size is above kMostBase64.
int countOf(std::string_view text) {
  if (text.size() > kMostBase64) throw Error("base64 of more than 1 GiB");
  return static_cast<int>(text.size());
}

const unsigned char* bytesOf(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

}  // namespace

Sha256::Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
  if (EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) throw Error("SHA-256 is not available in OpenSSL");
}

void Sha256::add(std::string_view bytes) {
  if (EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) != 1) throw Error("SHA-256 failed in OpenSSL");
}

std::string Sha256::hex() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_DigestFinal_ex(context_.get(), digest, &size) != 1) throw Error("SHA-256 failed in OpenSSL");
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
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // OpenSSL appends a zero byte
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytesOf(bytes), countOf(bytes));
  text.pop_back();
  return text;
}

std::optional<std::string> fromBase64(std::string_view text) {
  // OpenSSL would accept white space at both ends, "-" at the end, and padding in the middle (as zeroes): refuse them.
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1 || text.find_first_of("= \t\r\n-") != std::string_view::npos) return std::nullopt;
  const std::size_t padding = (4 - text.size() % 4) % 4;
  std::string padded(text);
  padded.append(padding, '=');
  std::string bytes(padded.size() / 4 * 3, '\0');
  auto* const decoded = reinterpret_cast<unsigned char*>(bytes.data());
  if (EVP_DecodeBlock(decoded, bytesOf(padded), countOf(padded)) < 0) return std::nullopt;
  bytes.resize(bytes.size() - padding);
  return bytes;
}

}  // namespace scanmill
