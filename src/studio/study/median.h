#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace scanmill {

// Returns the median; for an even number of values, the larger of the two middle values. Returns `none` if there are no
// values.
template <class T>
double medianOf(std::vector<T> values, double none = 0) {
  if (values.empty()) return none;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

// Returns the quantile `share` (0 to 1) of the values that are not NaN; NaN if there are none.
template <class T>
double quantileOf(std::vector<T> values, double share) {
  std::erase_if(values, [](T value) { return std::isnan(value); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

// Returns the mean; NaN if there are no values.
template <class T>
double meanOf(const std::vector<T>& values) {
  double sum = 0;
  for (const T v : values) sum += static_cast<double>(v);
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

}  // namespace scanmill
