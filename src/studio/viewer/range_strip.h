#pragma once

// The range image of a scan (rings x columns), and the mapping between its pixels and the points in the 3D view.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::uint32_t kNoPoint = 0xFFFFFFFFu;

struct RangeStrip {
  Image image;                         // the picture; one row per ring, the highest beams at the top
  std::vector<std::uint32_t> pointAt;  // index of the point that each pixel shows; kNoPoint: none
  // Pixel of each point (row * width + column), even if the pixel shows another point.
  std::vector<std::uint32_t> pixelOf;
  bool ringsRise = false;   // true: ring 0 is the lowest; it is in the last row
  bool outward = false;     // true: the image's left side is to the sensor's left; upright edges appear upright
  bool fullTurn = false;    // true: `outward` is true and the columns form a full turn; straight ahead is in the middle
  std::size_t columns = 0;  // number of the sensor's columns; the image is wider if rings of a partial turn are shifted

  // Returns the column and the row of the pixel of a point.
  std::pair<int, int> pixelPosition(std::size_t point) const {
    const auto width = static_cast<std::uint32_t>(image.width);
    return {static_cast<int>(pixelOf[point] % width), static_cast<int>(pixelOf[point] / width)};
  }
};

// Draws the range image of a scan, with a separate pixel for each beam. `colors`: one per point. `shown`: for each
// point, whether it is drawn; empty: all are drawn. If several points are in the same pixel, the nearest is drawn.
// `beams`: beam table of the sensor; null if unknown. If azimuths neither increase nor decrease with the column,
// columns are in the sensor's order. Throws InputError if the scan is too large for a picture, or if it is not
// organised and lacks `ring` or `column`.
RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown,
                          const BeamTable* beams = nullptr);

// Returns a description, such as "128 rings x 1024 columns, looking outward, straight ahead in the middle".
std::string describeStrip(const RangeStrip& strip);

}  // namespace scanmill
