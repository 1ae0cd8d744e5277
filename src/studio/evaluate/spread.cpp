#include "evaluate/spread.h"

#include <utility>

namespace scanmill {

Spread spreadOf(std::vector<double> values) {
  Spread s{.count = values.size()};
  if (values.empty()) return s;
  double sum = 0, squares = 0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  const auto n = static_cast<double>(values.size());
  s.mean = sum / n;
  s.rms = std::sqrt(squares / n);
  // Each percentile is searched only among the values that are not below the previous percentile.
  auto previous = values.begin();
  for (const auto& [share, percentile] :
       {std::pair(0.5, &Spread::median), {0.95, &Spread::p95}, {0.99, &Spread::p99}, {0.999, &Spread::p999}}) {
    const auto index = static_cast<std::size_t>(std::max(std::ceil(share * n) - 1, 0.0));
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::min(index, values.size() - 1));
    std::nth_element(previous, nth, values.end());
    s.*percentile = *nth;
    previous = nth;
  }
  s.max = *std::max_element(previous, values.end());
  return s;
}

double rocArea(std::vector<float> a, std::vector<float> b) {
  std::ranges::sort(a);
  std::ranges::sort(b);
  double twicePairs =
      0;  // twice the number of pairs (value of a, value of b) with b > a, plus the number of pairs with b = a
  auto notBelow = a.begin(), above = a.begin();
  for (const float value : b) {
    while (notBelow != a.end() && *notBelow < value) ++notBelow;
    while (above != a.end() && *above <= value) ++above;
    twicePairs += static_cast<double>(notBelow - a.begin()) + static_cast<double>(above - a.begin());
  }
  return twicePairs / (2.0 * static_cast<double>(a.size()) * static_cast<double>(b.size()));
}

}  // namespace scanmill
