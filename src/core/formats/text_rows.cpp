#include "formats/text_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>

#include "base/text_scan.h"

namespace scanmill {

namespace {

constexpr std::size_t kBuffer = 1 << 16;

// Largest number of characters of a number of this type, including the separator after the number.
template <class T>
constexpr std::size_t kLongest = std::is_same_v<T, float> ? 16  // "-1.17549435e-38"
                                 : std::is_same_v<T, double>
                                     ? 25  // for example "-2.2250738585072014e-308"
                                     : std::numeric_limits<T>::digits10 + 2 + (std::is_signed_v<T> ? 1 : 0);

std::size_t longestRowOf(const Scan& scan) {
  std::size_t length = 3 * kLongest<float>;
  visitColumns(scan, [&]<class T>(std::string_view, const std::vector<T>&) { length += kLongest<T>; });
  return length;
}

template <class T>
char* append(char* to, T value, char separator) {
  // A NaN's sign means nothing, and readers do not expect "-nan".
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(value)) value = std::numeric_limits<T>::quiet_NaN();
  }
  to = std::to_chars(to, to + kLongest<T>, value).ptr;
  *to++ = separator;
  return to;
}

}  // namespace

std::size_t longestRow(ColumnSet columns) {
  std::size_t length = 3 * kLongest<float>;
  forEachColumn([&]<class Key>(Key key) { length += columns.has(key) ? kLongest<typename Key::Value> : 0; });
  return length;
}

void appendRows(const Scan& scan, char separator, std::string& out) {
  const std::size_t longest = longestRowOf(scan);
  const std::size_t room = std::max(kBuffer, longest);
  const auto buffer = std::make_unique_for_overwrite<char[]>(room);
  char* to = buffer.get();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (to + longest > buffer.get() + room) {
      out.append(buffer.get(), to);
      to = buffer.get();
    }
    to = append(to, scan.position[i].x, separator);
    to = append(to, scan.position[i].y, separator);
    to = append(to, scan.position[i].z, separator);
    visitColumns(scan, [&](std::string_view, const auto& values) { to = append(to, values[i], separator); });
    to[-1] = '\n';
  }
  out.append(buffer.get(), to);
}

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
  throw InputError(where, fmt::format("{} must be {}, not '{}'{}", column, kind, word.substr(0, 40),
                                      std::is_integral_v<T> ? columnRemedy(column) : ""));
}

template void readNumber(std::string_view, float&, std::string_view, const Location&);
template void readNumber(std::string_view, double&, std::string_view, const Location&);
template void readNumber(std::string_view, std::uint8_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::uint16_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::uint32_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::uint64_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::int8_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::int16_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::int32_t&, std::string_view, const Location&);
template void readNumber(std::string_view, std::int64_t&, std::string_view, const Location&);

}  // namespace scanmill
