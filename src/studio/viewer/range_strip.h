#pragma once

// The scan as rings x columns, and which point stands where: the range image that is linked with the 3D view.

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
  Outward,  // like a photograph: straight ahead, or the middle of the field, in the middle, left on the left, and each
            // ring shifted by whole columns so that what stands upright is upright
  Sensor,   // the first column on the left, nothing shifted
};

struct RangeStrip {
  Image image;                         // a row per ring, the highest beams on top
  std::vector<std::uint32_t> pointAt;  // per pixel; kNoPoint where none is shown
  std::vector<std::uint32_t> pixelOf;  // per point, row * width + column, be it shown there or not
  bool ringsRise = false;              // ring 0 is the lowest beam, in the last row
  StripOrder order = StripOrder::Sensor;
  bool fullTurn = false;    // of the order Outward: ahead is in the middle
  std::size_t columns = 0;  // of the sensor; where the rings of a part of a revolution are shifted, the image is wider

  // Column and row of a point.
  std::pair<int, int> place(std::size_t point) const {
    const auto width = static_cast<std::uint32_t>(image.width);
    return {static_cast<int>(pixelOf[point] % width), static_cast<int>(pixelOf[point] / width)};
  }
};

// `colors`: one per point. `shown`: one per point, or empty for all; the others are left out, as if they were not
// there. Of several points on a pixel the nearest wins. Throws InputError where the scan is not organised and lacks
// ring or column, or is too large for a picture. A scan whose columns follow no azimuth is laid out in the order
// Sensor. Either way each beam has a pixel of its own. `beams`: of the scan's sensor; null where unknown.
RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown,
                          StripOrder order = StripOrder::Sensor, const BeamTable* beams = nullptr);

// "128 rings x 1024 columns, looking outward, straight ahead in the middle".
std::string describeStrip(const RangeStrip& strip, StripOrder wanted);

}  // namespace scanmill
