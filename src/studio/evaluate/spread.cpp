#include "evaluate/spread.h"

namespace scanmill {

Spread spreadOf(std::vector<double> values) {
  Spread s;
  s.count = values.size();
  if (values.empty()) return s;
  double sum = 0, squares = 0;
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

double rocArea(std::vector<float> a, std::vector<float> b) {
  std::ranges::sort(a);
  std::ranges::sort(b);
  double twice = 0;  // 2 x number of pairs (one value of each set) in which b is greater, plus number of equal pairs
  auto low = a.begin(), high = a.begin();
  for (const float value : b) {
    while (low != a.end() && *low < value) ++low;
    while (high != a.end() && *high <= value) ++high;
    twice += static_cast<double>(low - a.begin()) + static_cast<double>(high - a.begin());
  }
  return twice / (2.0 * static_cast<double>(a.size()) * static_cast<double>(b.size()));
}

}  // namespace scanmill
