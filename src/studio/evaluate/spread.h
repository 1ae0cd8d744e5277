#pragma once

// Computes percentiles and means of errors, and how far two sets of values are apart.

#include <cstddef>
#include <vector>

namespace scanmill {

// Statistics of a set of errors. All values are zero if there are no errors. The percentile p is the smallest value
// such that at least p per cent of the errors do not exceed it.
struct Spread {
  std::size_t count = 0;
  double mean = 0;
  double rms = 0;
  double median = 0;
  double p95 = 0;
  double p99 = 0;
  double p999 = 0;
  double max = 0;
  bool operator==(const Spread&) const = default;
};

Spread spreadOf(std::vector<double> values);

// Returns how well two sets of values can be separated by a threshold: the area under the receiver operating
// characteristic (ROC) curve. This is the probability that a random value of `b` is greater than a random value of `a`,
// where equal values count half (Hanley and McNeil, "The meaning and use of the area under a receiver operating
// characteristic (ROC) curve", Radiology 143, 1982). At 0.5 no threshold helps; at 0 or 1 a threshold separates the
// sets perfectly. Both sets must have values, none of them NaN.
double rocArea(std::vector<float> a, std::vector<float> b);

}  // namespace scanmill
