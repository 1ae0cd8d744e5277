#pragma once

#include <cstddef>
#include <vector>

namespace scanmill {

// How errors spread. All zero where there are none.
struct Spread {
  std::size_t count = 0;
  double mean = 0;
  double rms = 0;
  double median = 0;
  double p95 = 0;  // percentiles: the smallest value that so many per cent do not exceed
  double p99 = 0;
  double p999 = 0;
  double max = 0;
};

Spread spreadOf(std::vector<double> values);

}  // namespace scanmill
