#pragma once

// Writes numbers as bytes, the least significant first.

#include <bit>
#include <string>
#include <type_traits>

namespace scanmill {

template <class T>
requires std::is_arithmetic_v<T>
void putNumber(T value, std::string& bytes) {
  static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace scanmill
