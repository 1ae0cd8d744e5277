#include "report/dataset/scan_thinning.h"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

namespace scanmill {

namespace {

// An instance or a class with at most this number of points is kept complete if possible.
constexpr std::size_t kFewPoints = 1000;

// Adds a group for each value (instance id or class) that at most kFewPoints points have. `zeroIsNone`: points with the
// value 0 form no group.
template <class Value>
void addRare(const Scan& scan, const std::vector<Value>& values, const std::vector<std::size_t>& finite,
             bool zeroIsNone, std::vector<std::pair<std::size_t, std::vector<std::size_t>>>& groups) {
  if (values.size() != scan.size()) return;
  std::map<Value, std::vector<std::size_t>> pointsOf;
  for (const std::size_t i : finite) {
    if (!zeroIsNone || values[i] != 0) pointsOf[values[i]].push_back(i);
  }
  for (auto& [value, points] : pointsOf) {
    if (points.size() <= kFewPoints) groups.emplace_back(points.size(), std::move(points));
  }
}

double weightOf(const Vec3f& position) {
  constexpr double kLeast = 1e-3;  // least weight (m²): a point at the sensor must not have the weight zero
  const Vec3d p(position);
  return std::max(dot(p, p), kLeast);
}

// Returns the factor f for which the sum of min(f * weight, 1) over all weights is `kept`. f * weight is then the
// probability of keeping a point.
double factorFor(std::vector<double> weights, double kept) {
  std::ranges::sort(weights, std::greater<>());
  double rest = 0;
  for (const double w : weights) rest += w;
  for (std::size_t whole = 0; whole < weights.size(); ++whole) {
    const double factor = (kept - static_cast<double>(whole)) / rest;
    if (factor * weights[whole] <= 1) return factor;
    rest -= weights[whole];
  }
  return 0;
}

}  // namespace

std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most) {
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) finite.push_back(i);
  }
  if (finite.size() <= most) return finite;

  std::vector<bool> whole(scan.size(), false);
  std::size_t wholeCount = 0;
  std::vector<std::pair<std::size_t, std::vector<std::size_t>>> groups;
  addRare(scan, scan[kInstance], finite, true, groups);
  addRare(scan, scan[kLabel], finite, false, groups);
  std::ranges::stable_sort(groups, [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [count, points] : groups) {
    if (wholeCount + count > most / 2) break;
    for (const std::size_t i : points) {
      wholeCount += whole[i] ? 0 : 1;
      whole[i] = true;
    }
  }

  std::vector<double> weights;
  for (const std::size_t i : finite) {
    if (!whole[i]) weights.push_back(weightOf(scan.position[i]));
  }
  const double factor = factorFor(std::move(weights), static_cast<double>(most - wholeCount));
  // Add up the probabilities along the scan, and keep a point whenever the sum reaches one.
  std::vector<std::size_t> kept;
  double due = 0.5;
  for (const std::size_t i : finite) {
    if (whole[i]) {
      kept.push_back(i);
      continue;
    }
    due += std::min(factor * weightOf(scan.position[i]), 1.0);
    if (due < 1) continue;
    due -= 1;
    kept.push_back(i);
  }
  if (kept.size() > most) kept.resize(most);  // rounding may have caused one point too many
  return kept;
}

}  // namespace scanmill
