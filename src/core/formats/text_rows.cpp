#include "formats/text_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>

#include "formats/columns.h"

namespace scanmill {

namespace {

constexpr std::size_t kLongestNumber = 16;  // "-1.17549435e-38" and a separator
constexpr std::size_t kLongestRow = 11 * kLongestNumber;
constexpr std::size_t kBuffer = 1 << 16;

template <class T>
char* append(char* to, T value, char separator) {
  // The sign of a NaN says nothing, and "-nan" is not what readers expect.
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(value)) value = std::numeric_limits<T>::quiet_NaN();
  }
  to = std::to_chars(to, to + kLongestNumber, value).ptr;
  *to++ = separator;
  return to;
}

template <class T>
void readAny(std::string_view word, T& value, std::string_view column, const Location& where) {
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end || word.empty()) {
    const char* kind = std::is_floating_point_v<T>
                           ? "a number"
                           : (sizeof(T) == 2 ? "an integer of 0 to 65535" : "an integer of 0 to 4294967295");
    throw InputError(where, fmt::format("{} must be {}, not '{}'", column, kind, word.substr(0, 40)));
  }
}

}  // namespace

std::size_t longestRow(std::span<const std::string> names) {
  std::size_t length = 3 * kLongestNumber;
  visitNamedColumns(names, [&]<class T>(std::string_view, const std::vector<T>&) {
    length += std::is_floating_point_v<T> ? kLongestNumber : std::numeric_limits<T>::digits10 + 2;
  });
  return length;
}

void appendRows(const Scan& scan, char separator, std::string& out) {
  const auto buffer = std::make_unique_for_overwrite<char[]>(kBuffer);
  char* to = buffer.get();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (to + kLongestRow > buffer.get() + kBuffer) {
      out.append(buffer.get(), to);
      to = buffer.get();
    }
    to = append(to, scan.position[i].x, separator);
    to = append(to, scan.position[i].y, separator);
    to = append(to, scan.position[i].z, separator);
    visitOptionalColumns(scan, [&](std::string_view, const auto& column) {
      if (!column.empty()) to = append(to, column[i], separator);
    });
    to[-1] = '\n';
  }
  out.append(buffer.get(), to);
}

void readNumber(std::string_view word, float& value, std::string_view column, const Location& where) {
  readAny(word, value, column, where);
}

void readNumber(std::string_view word, std::uint16_t& value, std::string_view column, const Location& where) {
  readAny(word, value, column, where);
}

void readNumber(std::string_view word, std::uint32_t& value, std::string_view column, const Location& where) {
  readAny(word, value, column, where);
}

}  // namespace scanmill
