#include "viewer/window/range_strip.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

std::size_t ringOf(const Scan& scan, std::size_t i) {
  return scan.organised ? i / scan.columns : scan.ring[i];
}

std::size_t columnOf(const Scan& scan, std::size_t i) {
  return scan.organised ? i % scan.columns : scan.column[i];
}

// Whether elevations rise with the ring's number: the sign of their covariance.
bool elevationsRise(const Scan& scan) {
  double sumRing = 0, sumElevation = 0, sumBoth = 0, count = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    const Vec3d p(scan.position[i]);
    const double elevation = std::atan2(p.z, std::hypot(p.x, p.y));
    const auto ring = static_cast<double>(ringOf(scan, i));
    sumRing += ring;
    sumElevation += elevation;
    sumBoth += ring * elevation;
    count += 1;
  }
  return sumBoth * count > sumRing * sumElevation;
}

// Background, of the size of the sensor's rings and columns.
Image emptyGrid(const Scan& scan) {
  std::size_t rings = scan.rings;
  std::size_t columns = scan.columns;
  if (!scan.organised) {
    for (const char* name : {"ring", "column"}) {
      const auto& column = name[0] == 'r' ? scan.ring : scan.column;
      if (column.empty() && scan.size() > 0) {
        throw InputError(
            fmt::format("the scan has no column '{}', which a range image needs where a scan is not organised: name "
                        "it in the pipeline's output.columns",
                        name));
      }
    }
    for (const std::uint16_t r : scan.ring) rings = std::max<std::size_t>(rings, r + std::size_t{1});
    for (const std::uint16_t c : scan.column) columns = std::max<std::size_t>(columns, c + std::size_t{1});
  }
  if (rings > kMostPictureSide || columns > kMostPictureSide) {
    throw InputError(fmt::format("{} rings x {} columns do not fit a picture of at most {} x {}", rings, columns,
                                 kMostPictureSide, kMostPictureSide));
  }
  return {std::max(static_cast<int>(columns), 1), std::max(static_cast<int>(rings), 1), kBackground};
}

}  // namespace

RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown) {
  RangeStrip strip;
  strip.image = emptyGrid(scan);
  strip.ringsRise = elevationsRise(scan);
  strip.pointAt.assign(strip.image.pixels.size(), kNoPoint);
  strip.pixelOf.resize(scan.size());
  const auto width = static_cast<std::size_t>(strip.image.width);
  const auto rings = static_cast<std::size_t>(strip.image.height);
  std::vector<double> nearest(strip.image.pixels.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::size_t ring = ringOf(scan, i);
    const std::size_t row = strip.ringsRise ? rings - 1 - ring : ring;
    const std::size_t pixel = row * width + columnOf(scan, i);
    strip.pixelOf[i] = static_cast<std::uint32_t>(pixel);
    const double range = length(Vec3d(scan.position[i]));
    if (!(range < nearest[pixel]) || (!shown.empty() && !shown[i])) continue;  // a miss is not a number
    nearest[pixel] = range;
    strip.image.pixels[pixel] = colors[i];
    strip.pointAt[pixel] = static_cast<std::uint32_t>(i);
  }
  return strip;
}

}  // namespace scanmill
