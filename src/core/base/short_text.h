#pragma once

// Formats numbers, sizes, times and positions as short text for people.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Returns a number with three digits and a decimal prefix: "12.3 M", "456 k", "7".
std::string shortNumber(double value);

// Returns the smallest number that is at least `least` and equals 1, 2 or 5 times a power of ten.
double niceStep(double least);

// Formats a number as the label of an axis with this unit, such as "0.001", "10 k", "1 M", "10 µm" or "0.1 %".
// With the unit "%" the number is a fraction: 0.001 is "0.1 %".
std::string axisNumber(double value, const std::string& unit);

// Returns a number with its digits in groups of three: "1,234,567".
inline std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
  return digits;
}

// Returns a count with its noun, such as "1 scan" or "2,000 scans".
std::string pluralOf(std::uint64_t count, std::string_view noun);

// Returns texts separated by commas; if more than `most`, the first ones and a number: "a, b, c and 3 more".
std::string shortList(const std::vector<std::string>& texts, std::size_t most);

// Returns a size with a binary prefix: "1.2 GiB", "34.0 MiB", "12 B".
std::string shortBytes(double bytes);
std::string shortBytes(std::integral auto bytes) {
  return shortBytes(static_cast<double>(bytes));
}

// Returns a duration: "1 h 2 min", "4 min 5 s", "6.0 s".
std::string shortTime(double seconds);

// Returns a length with its unit: "12.3 m", "89.2 km".
std::string shortLength(double metres);

// Returns a position to the centimetre: "[1.00, -2.50, 0.12]".
std::string shortPosition(const Vec3d& point);

// Returns the edges of a box along x, y and z in m, such as "4.01 x 2.14 x 1.57 m", or "-" if the box is empty. Edges
// have three significant digits; from 100 m on they are whole metres.
std::string extentText(const Box& box);

}  // namespace scanmill
