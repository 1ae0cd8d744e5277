#pragma once

// Writes and reads numbers as bytes, the least significant first.

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace scanmill {

template <class T>
requires std::is_arithmetic_v<T>
void putNumber(T value, std::string& bytes) {
  static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// Returns the number that begins at the byte `at`.
template <class T>
T numberAt(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

}  // namespace scanmill
