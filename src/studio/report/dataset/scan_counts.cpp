#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "base/append_new.h"
#include "base/error.h"
#include "dataset/objects.h"
#include "report/dataset/scan_reading.h"

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

ScanCounts countScan(const Scan& scan, const RangeSteps& steps) {
  ScanCounts counts;
  // Neighbouring points mostly have the same class and instance, so counters are looked up only if a point's class or
  // instance differs from the previous point's.
  std::uint16_t previousClass = 0;
  std::vector<std::uint64_t>* ranges = nullptr;                   // points of previousClass per bin of range
  std::unordered_map<std::uint64_t, std::uint64_t> pointsOfPair;  // key: instance id << 16 | class
  std::uint64_t previousPair = 0;
  std::uint64_t* pairPoints = nullptr;  // points of previousPair
  std::vector<std::uint64_t> intensities(scan[kIntensity].empty() ? 0 : std::size_t{1} << 16, 0);  // by intensityKey()
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f& p = scan.position[i];
    if (!isFinite(p)) continue;
    ++counts.points;
    const std::uint16_t label = scan[kLabel].empty() ? std::uint16_t{0} : scan[kLabel][i];
    if (ranges == nullptr || label != previousClass) {
      ranges = &counts.rangesOfClass.try_emplace(label, steps.count, 0).first->second;
      previousClass = label;
    }
    ++(*ranges)[steps.of(length(Vec3d(p)))];
    if (!scan[kIntensity].empty() && std::isfinite(scan[kIntensity][i]))
      ++intensities[intensityKey(scan[kIntensity][i])];
    if (scan[kInstance].empty()) continue;
    const std::uint64_t pair = std::uint64_t{scan[kInstance][i]} << 16 | label;
    if (pairPoints == nullptr || pair != previousPair) {
      pairPoints = &pointsOfPair[pair];
      previousPair = pair;
    }
    ++*pairPoints;
  }
  for (std::size_t key = 0; key < intensities.size(); ++key) {
    if (intensities[key] > 0) counts.intensities.emplace(static_cast<std::uint16_t>(key), intensities[key]);
  }
  for (const auto& [pair, points] : pointsOfPair) {
    const auto id = static_cast<std::uint32_t>(pair >> 16);
    const auto label = static_cast<std::uint16_t>(pair & 0xFFFF);
    (id == 0 ? counts.withoutId : counts.instances[id])[label] = points;
  }
  return counts;
}

ObjectCounts countObjects(const ScanStore& store, const std::vector<std::size_t>& samples,
                          std::vector<std::string>& faults) {
  ObjectCounts counts;
  for (const std::size_t number : samples) {
    try {
      const std::optional<SampleObjects> list = store.objects(number);
      if (!list) continue;
      for (const ObjectRecord& object : list->objects) {
        for (const ObjectView& view : object.views) {
          const double visible = view.visibility().value_or(0);
          const std::size_t step = view.points == 0 ? 0
                                   : visible <= 0.4 ? 1
                                   : visible <= 0.6 ? 2
                                   : visible <= 0.8 ? 3
                                                    : 4;
          ++counts.ofClass[object.semantic][step];
          const double distance = length(view.sensorFromBox.translation);
          const auto band = std::upper_bound(kDistanceSteps.begin(), kDistanceSteps.end(), distance);
          ++counts.ofDistance[static_cast<std::size_t>(band - kDistanceSteps.begin())][step];
        }
      }
      ++counts.samples;
    } catch (const InputError& error) {
      appendNew({readingFault(store, number, error)}, faults);
    }
  }
  return counts;
}

}  // namespace scanmill
