#include "evaluate/spread.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

Spread spreadOf(std::vector<double> values) {
  Spread s;
  s.count = values.size();
  if (values.empty()) return s;
  double sum = 0;
  double squares = 0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  const auto n = static_cast<double>(values.size());
  // Each percentile is searched only among the values that are not below the previous percentile.
  auto from = values.begin();
  const auto at = [&](double share) {
    const auto place = static_cast<std::size_t>(std::max(std::ceil(share * n) - 1, 0.0));
    const auto found = values.begin() + static_cast<std::ptrdiff_t>(std::min(place, values.size() - 1));
    std::nth_element(from, found, values.end());
    from = found;
    return *found;
  };
  s.mean = sum / n;
  s.rms = std::sqrt(squares / n);
  s.median = at(0.5);
  s.p95 = at(0.95);
  s.p99 = at(0.99);
  s.p999 = at(0.999);
  s.max = *std::max_element(from, values.end());
  return s;
}

}  // namespace scanmill
