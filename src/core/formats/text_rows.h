#pragma once

// Writes scans as lines of numbers, for CSV and ASCII PCD, and checks the numbers of files of all formats.

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/error.h"
#include "base/text_scan.h"
#include "scan/scan.h"

namespace scanmill {

// Appends a line per point, with columns in the order of columnNames(), and with the fewest digits that preserve the
// bits.
void appendRows(const Scan& scan, char separator, std::string& out);

// Returns an upper bound of the characters in a line of a scan with these columns.
std::size_t longestRow(ColumnSet columns);

// Returns advice that ends a message about a number that does not fit the column; empty for most columns.
inline std::string_view columnRemedy(std::string_view column) {
  return column == "label"
             ? "; number the classes so, with 0 for none; if the numbers hold class and instance, as "
               "SemanticKITTI's do, write two columns, label = number & 0xFFFF and instance = number >> 16"
             : "";
}

// Reads the complete `word` as a number of type T, which may be any type of a column. Throws an InputError at `where`
// that names `column` if the word is not a number or T cannot represent it.
template <class T>
void readNumber(std::string_view word, T& value, std::string_view column, const Location& where) {
  if (parseNumber(word, value)) return;
  if constexpr (std::is_integral_v<T>) {
    // Other programs write whole numbers as 7.000000, too.
    double number = 0;
    if (parseNumber(word, number)) {
      constexpr double kExact = 9007199254740992.0;  // 2^53: up to here doubles hold all whole numbers
      const bool fits = number >= static_cast<double>(std::numeric_limits<T>::min()) && std::fabs(number) <= kExact &&
                        number <= static_cast<double>(std::numeric_limits<T>::max());
      if (fits && number == std::floor(number)) {
        value = static_cast<T>(number);
        return;
      }
    }
  }
  const std::string kind =
      std::is_floating_point_v<T>
          ? std::string("a number such as 1234.5 or -1.2e-3")
          : fmt::format("an integer of {} to {}", std::numeric_limits<T>::min(), std::numeric_limits<T>::max());
  throw InputError(where, "{} must be {}, not '{}'{}", column, kind, word.substr(0, 40),
                   std::is_integral_v<T> ? columnRemedy(column) : "");
}

// Returns the number as a value of a column of the type T. If T is an integer type that cannot hold the number (too
// small, too large, a fraction, or NaN), throws an InputError at `where` that names the column and the point.
template <class T, class Stored>
T columnValue(Stored stored, std::string_view name, std::size_t point, const Location& where) {
  if constexpr (!std::is_same_v<Stored, T> && std::is_integral_v<T>) {
    // The comparison is written so that NaN fails it, too.
    using Limits = std::numeric_limits<T>;
    const auto number = static_cast<long double>(stored);
    const bool fits = number >= Limits::min() && number <= Limits::max();
    const T value = fits ? static_cast<T>(stored) : T{};  // NOLINT(bugprone-signed-char-misuse): it fits
    if (!fits || static_cast<Stored>(value) != stored) {
      throw InputError(where, "{} of point {} is {}: no integer of {} to {}{}", name, point, stored, Limits::min(),
                       Limits::max(), where.file.empty() ? "" : columnRemedy(name));
    }
    return value;
  } else {
    return static_cast<T>(stored);
  }
}

// Calls visit(T{}). T is the type of numbers with this size (bytes) and this kind: F (floating-point), U (unsigned) or
// I (signed).
template <class Visit>
auto visitNumberType(char kind, std::uint64_t size, const Visit& visit) {
  if (kind == 'F') return size == 4 ? visit(float{}) : visit(double{});
  const bool isSigned = kind == 'I';
  switch (size) {
    case 1:
      return isSigned ? visit(std::int8_t{}) : visit(std::uint8_t{});
    case 2:
      return isSigned ? visit(std::int16_t{}) : visit(std::uint16_t{});
    case 4:
      return isSigned ? visit(std::int32_t{}) : visit(std::uint32_t{});
    default:
      return isSigned ? visit(std::int64_t{}) : visit(std::uint64_t{});
  }
}

}  // namespace scanmill
