#pragma once

// Computes percentiles and means of errors.

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

}  // namespace scanmill
