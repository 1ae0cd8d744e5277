#pragma once

// Computes percentiles and means, and how well two sets of values can be separated.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace scanmill {

// Statistics of a set of errors. All values are zero if there are no errors. The percentile p is the smallest value
// such that at least p per cent of the errors do not exceed it.
struct Spread {
  std::size_t count = 0;
  double mean = 0, rms = 0, median = 0, p95 = 0, p99 = 0, p999 = 0, max = 0;
  bool operator==(const Spread&) const = default;
};

Spread spreadOf(std::vector<double> values);

// Returns part / total; `ifNone` if the total is 0.
inline double shareOf(std::uint64_t part, std::uint64_t total, double ifNone = 0) {
  return total == 0 ? ifNone : static_cast<double>(part) / static_cast<double>(total);
}

// Returns how well two sets of values can be separated by a threshold: the area under the receiver operating
// characteristic (ROC) curve. This is the probability that a random value of `b` is greater than a random value of `a`,
// where equal values count half (Hanley and McNeil, "The meaning and use of the area under a receiver operating
// characteristic (ROC) curve", Radiology 143, 1982). At 0.5 no threshold helps; at 0 or 1 a threshold separates the
// sets perfectly. Both sets must have values, none of them NaN.
double rocArea(std::vector<float> a, std::vector<float> b);

// Returns the median; for an even number of values, the larger of the two in the middle; `none` if there are no values.
template <class T>
double medianOf(std::vector<T> values, double none = 0) {
  if (values.empty()) return none;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

// Returns the circular mean (rad, from -pi to pi) of angleOf(value) (rad) over all values.
double circularMean(const auto& values, const auto& angleOf) {
  double sine = 0, cosine = 0;
  for (const auto& value : values) {
    sine += std::sin(angleOf(value));
    cosine += std::cos(angleOf(value));
  }
  return std::atan2(sine, cosine);
}

// Returns the quantile `share` (0 to 1) of the values that are not NaN, between neighbours by linear interpolation; NaN
// if there are none.
template <class T>
double quantileOf(std::vector<T> values, double share) {
  std::erase_if(values, [](T value) { return std::isnan(value); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double index = share * static_cast<double>(values.size() - 1);
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(index);
  std::nth_element(values.begin(), nth, values.end());
  const auto low = static_cast<double>(*nth);
  if (nth + 1 == values.end()) return low;
  return low + (static_cast<double>(*std::min_element(nth + 1, values.end())) - low) * (index - std::floor(index));
}

// Returns the mean; NaN if there are no values.
template <class T>
double meanOf(const std::vector<T>& values) {
  double sum = 0;
  for (const T v : values) sum += static_cast<double>(v);
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

// Returns the standard deviation of a sample; 0 for fewer than two values.
inline double deviationOf(const std::vector<double>& values) {
  const double mean = meanOf(values);
  double squares = 0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return values.size() < 2 ? 0 : std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace scanmill
