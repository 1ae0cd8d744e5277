#pragma once

// LZF compression that gives the same bytes for the same input, since shards must be reproducible. liblzf's compressor
// may give other bytes in each run (see its lzf.h), because its table of earlier positions is not initialised.

#include <cstddef>

namespace scanmill {

// Returns the largest number of bytes to which `size` bytes can be compressed.
constexpr std::size_t mostLzfBytes(std::size_t size) {
  return size + size / 32 + 1;
}

// Compresses `size` bytes from `in` to `out`, which must have room for mostLzfBytes(size) bytes, and returns how many
// bytes it wrote. Any LZF decompressor can read the result. Format: M. A. Lehmann, liblzf, lzf_d.c.
std::size_t compressLzf(const char* in, std::size_t size, char* out);

}  // namespace scanmill
