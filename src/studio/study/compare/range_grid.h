#pragma once

// A scan as an image of its beams, so that a beam's neighbours are found whatever program or sensor made the scan.

#include <cstdint>
#include <limits>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// Rows are rings, from the top; columns are steps of azimuth, in the order in which the beams of a ring follow one
// another. Rows are shifted so that a column looks the same way in all of them, to half a step: sensors whose lasers
// stand beside one another have no such columns themselves. Of several returns of a beam the nearest is taken.
struct RangeGrid {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  bool wraps = false;        // the last column stands beside the first
  bool knowsRings = false;   // rows are the sensor's rings; else steps of elevation
  bool knowsMisses = false;  // a pixel without a point is a beam without a return; else it may lie between beams
  std::vector<std::uint32_t> point;   // of each pixel, row * columns + column: the index in the scan, or kNone
  std::vector<float> range;           // m, from the origin of the points' frame; NaN without a point
  std::vector<std::uint8_t> returns;  // how many the beam has

  std::size_t size() const { return point.size(); }
  std::size_t at(std::uint32_t row, std::uint32_t column) const { return std::size_t{row} * columns + column; }
  // The pixel so many columns further on in its row; kNone beyond the edge of a grid that does not wrap.
  std::uint32_t beside(std::uint32_t row, std::uint32_t column, int steps) const;
};

// Where the scan says which beams its points belong to, these are the pixels. Where it has rings alone, the step of
// azimuth is the median one from point to point, and a ring's points are set down in the order of their azimuths. Where
// it has neither, rows are 64 equal steps of the elevations that all but a hundredth of the points have, and columns
// 1024. A scan without points gives a grid without pixels.
RangeGrid rangeGrid(const Scan& scan);

}  // namespace scanmill
