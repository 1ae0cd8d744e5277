#pragma once

// The scan as rings x columns, and which point stands where: the range image that is linked with the 3D view.

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::uint32_t kNoPoint = 0xFFFFFFFFu;

struct RangeStrip {
  Image image;                         // a row per ring, the highest beams on top; a column per column
  std::vector<std::uint32_t> pointAt;  // per pixel; kNoPoint where none is shown
  std::vector<std::uint32_t> pixelOf;  // per point, row * width + column, be it shown there or not
  bool ringsRise = false;              // ring 0 is the lowest beam, in the last row

  // Column and row of a point.
  std::pair<int, int> place(std::size_t point) const {
    const auto width = static_cast<std::uint32_t>(image.width);
    return {static_cast<int>(pixelOf[point] % width), static_cast<int>(pixelOf[point] / width)};
  }
};

// `colors`: one per point. `shown`: one per point, or empty for all; the others are left out, as if they were not
// there. Of several points on a pixel the nearest wins. Throws InputError where the scan is not organised and lacks
// ring or column, or is too large for a picture.
RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown);

}  // namespace scanmill
