#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace scanmill {

inline double secondsOf(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The second of two runs in a row: the caches hold what this work reads, not what another left.
inline double secondsAfterWarmUp(const auto& work) {
  work();
  return secondsOf(work);
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace scanmill
