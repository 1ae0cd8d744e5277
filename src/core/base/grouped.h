#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace scanmill {

// Returns a number with its digits in groups of three: "1,234,567".
inline std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
  return digits;
}

}  // namespace scanmill
