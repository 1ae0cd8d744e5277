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
  // until visit() returns true. The order of the calls is fixed. Returns true if a call returned true.
  template <class Visit>
  bool forBeamsNear(const Vec3d& direction, double angle, const Visit& visit) const {
    const CellRange cells = cellsAround(direction, angle);
    for (std::uint32_t row = cells.firstRow; row <= cells.lastRow; ++row) {
      for (std::uint32_t i = 0; i < cells.columns; ++i) {
        const std::uint32_t cell = row * kAcross + (cells.firstColumn + i) % kAcross;
        for (std::uint32_t b = firstOf_[cell]; b < firstOf_[cell + 1]; ++b) {
          if (visit(beams_[b])) return true;
        }
      }
    }
    return false;
  }

  // Returns true if the sensor has beams around a direction: if the angle to the nearest beam is at most 10 degrees and
  // at most 1.5 times the usual angle between neighbouring beams. The usual angle is the 99th percentile over
  // neighbours in rings and columns. `near`: a beam that is tested first, then set to the beam that was found; with the
  // one of a neighbouring direction, most answers take one test.
  bool looksInto(const Vec3d& direction, std::uint32_t& near) const;

  // Returns the largest distance of a beam's origin from the sensor's origin (m).
  double farthestOrigin() const { return farthestOrigin_; }

 private:
  // The grid has cells of one degree of azimuth and elevation.
  static constexpr std::uint32_t kAcross = 360;
  static constexpr std::uint32_t kUp = 180;

  // rowOf() returns the row of cells at an elevation (rad), columnOf() the column at an azimuth (rad, of any turn).
  static std::uint32_t rowOf(double elevation);
  static std::uint32_t columnOf(double azimuth);
  // Rows from firstRow to lastRow; in each row `columns` cells from firstColumn on, which may extend across azimuth 0.
  struct CellRange {
    std::uint32_t firstRow = 0, lastRow = 0, firstColumn = 0, columns = 0;
  };
  // Returns the cells that a cone about `direction` with the half angle `angle` (rad) may touch.
  static CellRange cellsAround(const Vec3d& direction, double angle);

  const std::vector<Vec3d>& directions_;
  std::vector<std::uint32_t> firstOf_;  // by cell: index in beams_ of the cell's first beam; last entry: size of beams_
  std::vector<std::uint32_t> beams_;    // indices of the beams, sorted by cell
  double farthestOrigin_ = 0;
  double neighbourAngle_ = 0;  // rad, largest angle to the nearest beam for which looksInto() returns true
};

}  // namespace scanmill
