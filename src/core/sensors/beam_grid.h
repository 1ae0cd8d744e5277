#pragma once

// Finds the beams of a sensor that point into a cone, without testing all beams.

#include <cstdint>
#include <vector>

#include "sensors/beams.h"

namespace scanmill {

class BeamGrid {
 public:
  // Sorts the beams by direction, in the sensor's frame. The table must outlive the grid.
  explicit BeamGrid(const BeamTable& beams);

  // Calls visit(index) for every beam within `angle` (rad) of a unit vector, and also for some beams farther away,
  // until it returns true. The order of the calls is fixed. Returns true if visit() has.
  template <class Visit>
  bool forBeamsNear(const Vec3d& direction, double angle, const Visit& visit) const {
    std::uint32_t low = 0, high = 0, first = 0, count = 0;
    cellsOf(direction, angle, low, high, first, count);
    for (std::uint32_t row = low; row <= high; ++row) {
      for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t cell = row * kAcross + (first + i) % kAcross;
        for (std::uint32_t b = firstOf_[cell]; b < firstOf_[cell + 1]; ++b) {
          if (visit(beams_[b])) return true;
        }
      }
    }
    return false;
  }

  // Returns true if the sensor has beams around a direction: if the angle to the nearest beam is at most 10 degrees and
  // at most 1.5 times the usual angle between neighbouring beams. The usual angle is the 99th percentile over
  // neighbours in rings and columns.
  bool looksInto(const Vec3d& direction) const;

  // Returns the largest distance of a beam's origin from the sensor's origin (m).
  double farthestOrigin() const { return farthestOrigin_; }

 private:
  // The grid has cells of one degree of azimuth and elevation.
  static constexpr std::uint32_t kAcross = 360;
  static constexpr std::uint32_t kUp = 180;

  static std::uint32_t rowOf(double elevation);
  static std::uint32_t columnOf(double azimuth);
  static void cellsOf(const Vec3d& direction, double angle, std::uint32_t& low, std::uint32_t& high,
                      std::uint32_t& first, std::uint32_t& count);

  const std::vector<Vec3d>& directions_;
  std::vector<std::uint32_t> firstOf_;  // by cell: index in beams_ of the cell's first beam; last entry: size of beams_
  std::vector<std::uint32_t> beams_;    // indices of the beams, sorted by cell
  double farthestOrigin_ = 0;
  double reach_ = 0;  // rad, largest angle to the nearest beam for which looksInto() returns true
};

}  // namespace scanmill
