#pragma once

// Hashes of bytes, and bytes as text in base64 (RFC 4648, section 4).

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct evp_md_ctx_st;  // a type of OpenSSL

namespace scanmill {

// Computes the SHA-256 (FIPS 180-4) of bytes that arrive in pieces.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  // Returns the hash of all bytes added, as 64 hexadecimal digits in lower case. The object cannot be used afterwards.
  std::string hex();

 private:
  std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

// Returns the SHA-256 of bytes in memory, as Sha256::hex() does.
std::string sha256(std::string_view bytes);

// Returns the SHA-256 of a whole file. Throws an Error that names the file if it cannot be read.
std::string sha256OfFile(const std::filesystem::path& file);

// Returns the XXH3 hash (Collet, xxhash.com; 64 bits) of bytes as 16 hexadecimal digits in lower case, as `xxhsum -H3`
// prints it. It finds damage ten times as fast as SHA-256, but does not withstand deliberate forgery.
std::string xxh3(std::string_view bytes);

// Returns the XXH3 hash of a whole file, as xxh3() does. Throws an InputError that names the file if it cannot be read.
std::string xxh3OfFile(const std::filesystem::path& file);

// Returns the FNV-1a hash (Fowler, Noll and Vo; RFC 9923) of a text. Unlike std::hash it is the same on all machines.
constexpr std::uint32_t fnv1a(std::string_view text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 16777619u;
  return hash;
}

// The largest size (bytes) that the next two functions accept. They throw Error for longer input.
inline constexpr std::size_t kMostBase64 = std::size_t{1} << 30;
std::string base64(std::string_view bytes);
// Returns the bytes that the text encodes; nullopt if the text is not base64. Padding at the end may be left out.
std::optional<std::string> fromBase64(std::string_view text);

}  // namespace scanmill
