#include "evaluate/roc.h"

#include <algorithm>

namespace scanmill {

double rocArea(std::vector<float> a, std::vector<float> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
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
