#pragma once

// The range image of a scan (rings x columns), with the pixel of each point and the point at each pixel; it is linked
// with the 3D view.

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
  Outward,  // like a photograph: straight ahead, or the middle of the field of view, in the middle, left on the left;
            // each ring is shifted by whole columns so that upright things are upright in the image
  Sensor,   // the first column on the left, no ring shifted
};

struct RangeStrip {
  Image image;                         // a row per ring, the highest beams on top
  std::vector<std::uint32_t> pointAt;  // per pixel, index of the point; kNoPoint if none is shown
  std::vector<std::uint32_t> pixelOf;  // per point, row * width + column, even if that pixel shows another point
  bool ringsRise = false;              // ring 0 is the lowest beam, in the last row
  StripOrder order = StripOrder::Sensor;
  bool fullTurn = false;    // in the order Outward: straight ahead is in the middle
  std::size_t columns = 0;  // of the sensor; the image is wider if rings of less than a revolution are shifted

  // Returns the column and the row of a point.
  std::pair<int, int> place(std::size_t point) const {
    const auto width = static_cast<std::uint32_t>(image.width);
    return {static_cast<int>(pixelOf[point] % width), static_cast<int>(pixelOf[point] / width)};
  }
};

// Draws the range image of a scan. `colors`: one per point. `shown`: one per point, or empty for all; points that are
// not shown are skipped. If several points fall on one pixel, the nearest is shown. Throws InputError if the scan is
// not organised and lacks ring or column, or is too large for a picture. A scan whose columns do not follow the azimuth
// is laid out in the order Sensor. In both orders each beam has a pixel of its own. `beams`: the table of the scan's
// sensor; null if unknown.
RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown,
                          StripOrder order = StripOrder::Sensor, const BeamTable* beams = nullptr);

// Returns "128 rings x 1024 columns, looking outward, straight ahead in the middle".
std::string describeStrip(const RangeStrip& strip, StripOrder wanted);

}  // namespace scanmill
