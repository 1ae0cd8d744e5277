#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace scanmill {

// The bytes of a PNG of one channel of 8 bits, which readers give as an array of two dimensions. Pixels are row by row,
// from the top left; their number is a multiple of `width`. Throws Error where there is no memory to deflate with.
std::string greyPng(std::span<const std::uint8_t> pixels, std::uint32_t width);

}  // namespace scanmill
