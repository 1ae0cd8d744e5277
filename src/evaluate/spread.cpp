#include "evaluate/spread.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

Spread spreadOf(std::vector<double> values) {
  Spread s;
  s.count = values.size();
  if (values.empty()) return s;
  std::sort(values.begin(), values.end());
  double sum = 0;
  double squares = 0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  const auto n = static_cast<double>(values.size());
  const auto at = [&](double share) {
    const auto place = static_cast<std::size_t>(std::max(std::ceil(share * n) - 1, 0.0));
    return values[std::min(place, values.size() - 1)];
  };
  s.mean = sum / n;
  s.rms = std::sqrt(squares / n);
  s.median = at(0.5);
  s.p95 = at(0.95);
  s.p99 = at(0.99);
  s.p999 = at(0.999);
  s.max = values.back();
  return s;
}

}  // namespace scanmill
