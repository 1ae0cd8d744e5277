#pragma once

// LZF compression that gives the same bytes for the same input. liblzf states that its own compressor may give other
// bytes from run to run (lzf.h: its table of earlier places starts with whatever the memory held), and shards must not.

#include <cstddef>
#include <string>

namespace scanmill {

// The size of the largest result for so many bytes.
constexpr std::size_t mostLzfBytes(std::size_t size) {
  return size + size / 32 + 1;
}

// Compresses `size` bytes from `in` to `out`, where mostLzfBytes(size) bytes are free, and returns how many it wrote.
// Any reader of LZF takes the result. Format: M. A. Lehmann, liblzf, lzf_d.c.
std::size_t compressLzf(const char* in, std::size_t size, char* out);

}  // namespace scanmill
