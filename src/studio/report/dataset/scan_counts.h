#pragma once

// Counts the contents of one scan. Counts are whole numbers, so that sums do not depend on the order of adding.

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

// Distances from the sensor in steps; the last step holds all larger distances.
struct RangeSteps {
  double step = 1;  // m
  std::size_t count = 1;

  std::size_t of(double distance) const {
    const double place = distance / step;
    return place < static_cast<double>(count - 1) ? static_cast<std::size_t>(place) : count - 1;
  }
};

// Returns steps of 0.1, 0.2, 0.5, 1, 2, 5 and so on metres: at most 120 up to the farthest range, and one beyond.
RangeSteps rangeStepsFor(double farthest);

// Intensities are counted by the upper half of their float32 bits: to within 1 in 128, whole numbers to 255 exactly.
std::uint16_t intensityKey(float intensity);  // 0 for an intensity that is not above 0
float intensityOfKey(std::uint16_t key);      // the smallest intensity with this key

// The size (m) of the visible part of an object: the upright box with the smallest base that holds its points.
struct SeenSize {
  double length = 0, width = 0, height = 0;  // length >= width
};

struct InstanceCounts {
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass;
  Box box;        // box of the instance's points, in the level frame
  SeenSize size;  // size of the instance's points, in the level frame
};

struct ScanCounts {
  std::uint64_t points = 0;                                           // finite points
  std::map<std::uint16_t, std::vector<std::uint64_t>> rangesOfClass;  // if there are no labels, all points have class 0
  std::map<std::uint16_t, std::uint64_t> intensities;                 // by key
  std::vector<InstanceCounts> instances;                              // ascending ids, without 0
  std::map<std::uint16_t, std::uint64_t> withoutId;                   // points without an instance, by class
};

// Returns the rotation into a level frame at the sensor, whose x axis is the sensor's x axis projected to the
// horizontal. It uses the orientation of the sensor at the start of its revolution.
Mat3 levelFromSensor(const Quat& worldFromSensor);

ScanCounts countScan(const Scan& scan, const RangeSteps& steps, const Mat3& levelFromSensor = {});

}  // namespace scanmill
