#pragma once

#include <algorithm>
#include <vector>

#include "base/stage_clock.h"

namespace scanmill {

inline std::vector<double> secondsOfEach(int runs, const auto& work) {
  std::vector<double> seconds;
  for (int i = 0; i < runs; ++i) seconds.push_back(secondsOf(work));
  return seconds;
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace scanmill
