#pragma once

// A scan as an image of its beams, which gives a beam's neighbours whatever program or sensor made the scan.

#include <cstdint>
#include <limits>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// Rows are rings, from the top; columns are steps of azimuth, in the firing order of a ring. Rows are shifted so that a
// column has the same azimuth in all of them, to half a step: the columns of sensors with lasers side by side do not.
// Of several returns of a beam the nearest is taken.
struct RangeGrid {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  bool wraps = false;        // the last column adjoins the first
  bool knowsRings = false;   // rows are the sensor's rings; otherwise steps of elevation
  bool knowsMisses = false;  // a pixel without a point is a beam without a return; otherwise it may lie between beams
  std::vector<std::uint32_t> point;   // for each pixel (row * columns + column) the point's index in the scan, or kNone
  std::vector<float> range;           // m, from the origin of the points' frame; NaN without a point
  std::vector<std::uint8_t> returns;  // number of returns of the beam

  std::size_t size() const { return point.size(); }
  std::size_t at(std::uint32_t row, std::uint32_t column) const { return std::size_t{row} * columns + column; }
  // Returns the pixel `steps` columns further in its row; kNone beyond the edge of a grid that does not wrap.
  std::uint32_t beside(std::uint32_t row, std::uint32_t column, int steps) const;
};

// Builds the grid. If the scan assigns its points to beams, the pixels are these beams. If the scan has only rings, the
// step of azimuth is the median step from point to point, and a ring's points are placed in the order of their
// azimuths. If it has neither, the grid has 64 rows of equal steps over the elevations of the middle 99 % of the
// points, and 1024 columns. A scan without points gives a grid without pixels.
RangeGrid rangeGrid(const Scan& scan);

}  // namespace scanmill
