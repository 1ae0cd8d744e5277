#include "formats/lzf.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace scanmill {

namespace {

constexpr std::ptrdiff_t kLeastMatch = 3;
constexpr std::size_t kMostMatch = 264;
constexpr std::size_t kMostDistance = 8192;  // largest distance (bytes) back to an earlier occurrence
constexpr std::size_t kMostLiterals = 32;    // largest number of literals after one control byte
constexpr unsigned kTableBits = 16;

// Returns the index in the hash table for the three bytes at `p`.
std::uint32_t hashAt(const unsigned char* p) {
  const std::uint32_t bytes = p[0] | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16;
  // Multiplicative hashing: Knuth, The Art of Computer Programming 3, 6.4.
  return bytes * 2654435761u >> (32 - kTableBits);
}

// These two functions write to `out` and return the end of the written bytes. putLiterals() writes bytes unchanged,
// putMatch() a reference to `length` earlier bytes, which begin `back` bytes before the current position.
char* putLiterals(const unsigned char* from, const unsigned char* end, char* out) {
  while (from < end) {
    const std::size_t count = std::min<std::size_t>(kMostLiterals, static_cast<std::size_t>(end - from));
    *out++ = static_cast<char>(count - 1);
    std::memcpy(out, from, count);
    out += count;
    from += count;
  }
  return out;
}

char* putMatch(std::size_t back, std::size_t length, char* out) {
  const std::size_t code = length - 2;
  *out++ = static_cast<char>((std::min<std::size_t>(code, 7) << 5) | ((back - 1) >> 8));
  if (code >= 7) *out++ = static_cast<char>(code - 7);
  *out++ = static_cast<char>((back - 1) & 0xff);
  return out;
}

}  // namespace

std::size_t compressLzf(const char* in, std::size_t size, char* out) {
  const auto* const begin = reinterpret_cast<const unsigned char*>(in);
  const unsigned char* const end = begin + size;
  const char* const start = out;
  thread_local std::vector<std::uint32_t> latest;  // by hash: 1 + latest position of bytes with this hash; 0: none
  latest.assign(std::size_t{1} << kTableBits, 0);
  const unsigned char* literals = begin;  // start of the literals that are not written yet
  const unsigned char* p = begin;
  while (end - p >= kLeastMatch) {
    std::uint32_t& slot = latest[hashAt(p)];
    const auto position1 = static_cast<std::size_t>(p - begin) + 1;  // 1 + position of p, as in `latest`
    const std::size_t earlier1 = slot;
    slot = static_cast<std::uint32_t>(position1);
    const std::size_t back = position1 - earlier1;  // bytes from the earlier position to p
    if (earlier1 == 0 || back > kMostDistance || std::memcmp(p - back, p, kLeastMatch) != 0) {
      ++p;
      continue;
    }
    const auto mostLength = std::min(kMostMatch, static_cast<std::size_t>(end - p));
    std::size_t length{kLeastMatch};
    while (length < mostLength && *(p + length - back) == p[length]) ++length;
    out = putLiterals(literals, p, out);
    out = putMatch(back, length, out);
    p += length;
    literals = p;
    // Besides the first position of a match, only its last two positions are entered into the table.
    for (const unsigned char* q = p - 2; q < p && end - q >= kLeastMatch; ++q) {
      latest[hashAt(q)] = static_cast<std::uint32_t>(q - begin + 1);
    }
  }
  out = putLiterals(literals, end, out);
  return static_cast<std::size_t>(out - start);
}

}  // namespace scanmill
