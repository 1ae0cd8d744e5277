#include "study/dataset/scan_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

namespace scanmill {

RangeSteps rangeStepsFor(double farthest) {
  constexpr double kMostSteps = 120;
  double step = 0.1;
  for (int i = 0; farthest / step > kMostSteps; ++i) step *= i % 3 == 1 ? 2.5 : 2;
  return {step, static_cast<std::size_t>(std::ceil(std::max(farthest, step) / step)) + 1};
}

std::uint16_t intensityKey(float intensity) {
  return intensity > 0 ? static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(intensity) >> 16) : std::uint16_t{0};
}

float intensityOfKey(std::uint16_t key) {
  return std::bit_cast<float>(std::uint32_t{key} << 16);
}

ScanCounts countScan(const Scan& scan, const Ontology& ontology, const RangeSteps& steps) {
  ScanCounts counts;
  std::vector<std::uint64_t>* ranges = nullptr;  // of the last point's class: neighbours mostly share it
  std::uint16_t lastClass = 0;
  std::unordered_map<std::uint64_t, std::uint64_t> pairs;  // id and class
  std::uint64_t lastPair = 0;
  std::uint64_t* pairPoints = nullptr;
  std::vector<std::uint64_t> intensities(scan.intensity.empty() ? 0 : std::size_t{1} << 16, 0);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f& p = scan.position[i];
    if (!isFinite(p)) continue;
    ++counts.points;
    const std::uint16_t label = scan.label.empty() ? std::uint16_t{0} : scan.label[i];
    if (ranges == nullptr || label != lastClass) {
      ranges = &counts.rangesOfClass.try_emplace(label, steps.count, 0).first->second;
      lastClass = label;
    }
    ++(*ranges)[steps.of(length(Vec3d(p)))];
    if (!scan.intensity.empty() && std::isfinite(scan.intensity[i])) ++intensities[intensityKey(scan.intensity[i])];
    if (scan.instance.empty()) continue;
    const std::uint64_t pair = std::uint64_t{scan.instance[i]} << 16 | label;
    if (pairPoints == nullptr || pair != lastPair) {
      pairPoints = &pairs[pair];
      lastPair = pair;
    }
    ++*pairPoints;
  }
  for (std::size_t key = 0; key < intensities.size(); ++key) {
    if (intensities[key] > 0) counts.intensities.emplace(static_cast<std::uint16_t>(key), intensities[key]);
  }
  std::map<std::uint32_t, InstanceCounts> instances;
  for (const auto& [pair, points] : pairs) {
    const auto id = static_cast<std::uint32_t>(pair >> 16);
    const auto label = static_cast<std::uint16_t>(pair & 0xFFFF);
    if (id != 0) {
      InstanceCounts& own = instances[id];
      own.id = id;
      own.pointsOfClass[label] = points;
    } else if (const SemanticClass* known = ontology.find(label); known != nullptr && known->thing) {
      counts.thingsWithoutId[label] = points;
    }
  }
  for (auto& [id, own] : instances) counts.instances.push_back(std::move(own));
  return counts;
}

}  // namespace scanmill
