#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace scanmill {

// The median, of an even number of values the upper one of the middle two; `none` of no values.
template <class T>
double medianOf(std::vector<T> values, double none = 0) {
  if (values.empty()) return none;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

// NaN where there are no values.
template <class T>
double meanOf(const std::vector<T>& values) {
  double sum = 0;
  for (const T v : values) sum += static_cast<double>(v);
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

}  // namespace scanmill
