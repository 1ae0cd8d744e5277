#pragma once

// Writes numbers as bytes, the least significant first, on any machine.

#include <bit>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>

namespace scanmill {

template <class T>
requires std::is_arithmetic_v<T>
void putNumber(T value, std::string& bytes) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t,
                                  std::conditional_t<sizeof(T) == 4, std::uint32_t,
                                                     std::conditional_t<sizeof(T) == 2, std::uint16_t, std::uint8_t>>>;
  auto bits = std::bit_cast<Bits>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes += static_cast<char>(static_cast<unsigned char>(bits >> (8 * i)));
  }
}

}  // namespace scanmill
