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

enum class StripOrder {
  Outward,  // like a photograph: the middle shows straight ahead, or the middle of the field of view, and the left side
            // shows the left; each ring is shifted by an integer number of columns, so that vertical things are
            // vertical in the image
  Sensor,   // the first column is on the left; no ring is shifted
};

struct RangeStrip {
  Image image;                         // one row per ring, with the highest beams at the top
  std::vector<std::uint32_t> pointAt;  // for each pixel, the index of the point that it shows; kNoPoint: none
  std::vector<std::uint32_t> pixelOf;  // for each point, row * width + column, even if the pixel shows another point
  bool ringsRise = false;              // true: ring 0 is the lowest beam and is in the last row
  StripOrder order = StripOrder::Sensor;
  bool fullTurn = false;  // true in the order Outward if the middle shows straight ahead
  // Number of the sensor's columns; the image may be wider, if rings of less than a revolution are shifted.
  std::size_t columns = 0;

  // Returns the column and the row of a point in the image.
  std::pair<int, int> place(std::size_t point) const {
    const auto width = static_cast<std::uint32_t>(image.width);
    return {static_cast<int>(pixelOf[point] % width), static_cast<int>(pixelOf[point] / width)};
  }
};

// Draws the range image of a scan, with a separate pixel for each beam. `colors`: one per point. `shown`: for each
// point, whether it is drawn; empty: all are. If several points are in the same pixel, the nearest is drawn. `beams`:
// beam table of the sensor; null if unknown. If azimuths do not increase or decrease with the column, the order is
// Sensor. Throws InputError if the scan is too large for a picture, or if it is not organised and has no columns ring
// and column.
RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown,
                          StripOrder order = StripOrder::Sensor, const BeamTable* beams = nullptr);

// Returns a description of the image, such as "128 rings x 1024 columns, looking outward, straight ahead in the
// middle".
std::string describeStrip(const RangeStrip& strip, StripOrder wanted);

}  // namespace scanmill
