#pragma once

// Arranges the points of any scan as an image of the sensor's beams, so that the neighbours of a beam are known.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// A scan as an image. Rows are rings, or steps of elevation, from top to bottom; columns are successive azimuth steps.
// Rows are shifted such that a column has the same azimuth in all rows, to within half a step; this matters for lasers
// side by side, whose columns differ in azimuth. If a beam has several returns, the pixel has the nearest.
struct RangeGrid {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t rows = 0, columns = 0;
  bool wraps = false;        // true: the last column is a neighbour of the first
  bool knowsRings = false;   // true: rows are the sensor's rings; false: rows are steps of elevation
  bool knowsMisses = false;  // true: an empty pixel is a beam without a return; false: it may be a gap between beams
  std::vector<std::uint32_t> point;   // index in the scan for each pixel (row * columns + column); kNone: empty
  std::vector<float> range;           // distance from the origin of the points' frame for each pixel (m); NaN: empty
  std::vector<std::uint8_t> returns;  // number of returns of each pixel's beam

  std::size_t size() const { return point.size(); }
  std::size_t at(std::uint32_t row, std::uint32_t column) const { return std::size_t{row} * columns + column; }
  // Returns the index of the pixel that is `steps` columns to the right in the same row (to the left if negative);
  // kNone beyond the edge of a grid that does not wrap.
  std::uint32_t beside(std::uint32_t row, std::uint32_t column, int steps) const;
};

// Builds the grid of a scan. If the scan assigns its points to beams, the pixels are these beams. If the scan has only
// rings, the column width is the median azimuth step between consecutive points, and the points of a ring are placed in
// the order of their azimuths. If the scan has neither, the grid has 1024 columns and 64 rows, which divide the
// elevations of the middle 99 % of the points evenly. A scan without points gives an empty grid.
RangeGrid rangeGrid(const Scan& scan);

}  // namespace scanmill
