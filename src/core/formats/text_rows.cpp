#include "formats/text_rows.h"

#include <algorithm>
#include <charconv>
#include <memory>

namespace scanmill {

namespace {

constexpr std::size_t kBuffer = 1 << 16;  // bytes of text that are written at once

// Largest number of characters of a number of this type, including the separator after the number.
template <class T>
constexpr std::size_t kLongest = std::is_same_v<T, float> ? 16  // "-1.17549435e-38"
                                 : std::is_same_v<T, double>
                                     ? 25  // for example "-2.2250738585072014e-308"
                                     : std::numeric_limits<T>::digits10 + 2 + (std::is_signed_v<T> ? 1 : 0);

// Writes a number and the separator to `to`. Returns the position after the separator.
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
  std::size_t rowBytes = 3 * kLongest<float>;  // of the longest row
  visitColumns(scan, [&]<class T>(std::string_view, const std::vector<T>&) { rowBytes += kLongest<T>; });
  const std::size_t bufferBytes = std::max(kBuffer, rowBytes);
  const auto buffer = std::make_unique_for_overwrite<char[]>(bufferBytes);
  char* to = buffer.get();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (to + rowBytes > buffer.get() + bufferBytes) {
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

}  // namespace scanmill
