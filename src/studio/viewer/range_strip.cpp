#include "viewer/range_strip.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"
#include "viewer/strip_columns.h"

namespace scanmill {

namespace {

// True if elevations increase with the ring number, determined by the sign of their covariance.
bool elevationsRise(const Scan& scan) {
  double sumRing = 0, sumElevation = 0, sumBoth = 0, count = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    const Vec3d p(scan.position[i]);
    const double elevation = std::atan2(p.z, std::hypot(p.x, p.y));
    const auto ring = static_cast<double>(keyOf(scan, i).ring);
    sumRing += ring;
    sumElevation += elevation;
    sumBoth += ring * elevation;
    count += 1;
  }
  return sumBoth * count > sumRing * sumElevation;
}

struct GridSize {
  std::size_t rings = 1;
  std::size_t columns = 1;
};

// Returns the scan's numbers of rings and columns; if it is not organised, as many as its points need.
GridSize gridOf(const Scan& scan) {
  GridSize size{std::max<std::size_t>(scan.rings, 1), std::max<std::size_t>(scan.columns, 1)};
  if (!scan.organised) {
    for (const char* name : {"ring", "column"}) {
      const auto& column = name[0] == 'r' ? scan[kRing] : scan[kColumn];
      if (column.empty() && scan.size() > 0) {
        throw InputError(
            fmt::format("the scan has no column '{}', which a range image needs where a scan is not organised: name "
                        "it in the pipeline's output.columns",
                        name));
      }
    }
    for (const std::uint16_t r : scan[kRing]) size.rings = std::max(size.rings, r + std::size_t{1});
    for (const std::uint16_t c : scan[kColumn]) size.columns = std::max(size.columns, c + std::size_t{1});
  }
  if (size.rings <= kMostPictureSide && size.columns <= kMostPictureSide) return size;
  throw InputError(fmt::format("{} rings x {} columns do not fit a picture of at most {} x {}", size.rings,
                               size.columns, kMostPictureSide, kMostPictureSide));
}

}  // namespace

RangeStrip makeRangeStrip(const Scan& scan, std::span<const Rgb> colors, const std::vector<bool>& shown,
                          const BeamTable* beams) {
  const GridSize grid = gridOf(scan);
  RangeStrip strip;
  strip.columns = grid.columns;
  std::vector<std::size_t> ring(scan.size());
  std::vector<std::size_t> column(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    ring[i] = key.ring;
    column[i] = key.column;
  }
  std::size_t width = grid.columns;
  const auto look = stripColumns(scan, ring, column, grid.rings, grid.columns, beams);
  const auto places = look ? lookingOutward(*look, grid.columns) : std::nullopt;
  if (places && places->image.width <= kMostPictureSide) {
    for (std::size_t i = 0; i < scan.size(); ++i) column[i] = places->place(ring[i], column[i]);
    width = places->image.width;
    strip.outward = true;
    strip.fullTurn = look->fullTurn;
  }
  strip.image = Image(static_cast<int>(width), static_cast<int>(grid.rings), kBackground);
  strip.ringsRise = elevationsRise(scan);
  strip.pointAt.assign(strip.image.pixels.size(), kNoPoint);
  strip.pixelOf.resize(scan.size());
  std::vector<double> nearest(strip.image.pixels.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::size_t row = strip.ringsRise ? grid.rings - 1 - ring[i] : ring[i];
    const std::size_t pixel = row * width + column[i];
    strip.pixelOf[i] = static_cast<std::uint32_t>(pixel);
    const double range = length(Vec3d(scan.position[i]));
    if (!(range < nearest[pixel]) || (!shown.empty() && !shown[i])) continue;  // also skips misses, whose range is NaN
    nearest[pixel] = range;
    strip.image.pixels[pixel] = colors[i];
    strip.pointAt[pixel] = static_cast<std::uint32_t>(i);
  }
  return strip;
}

std::string describeStrip(const RangeStrip& strip) {
  const char* how = "in the sensor's order: its columns do not follow the azimuth";
  if (strip.outward) how = strip.fullTurn ? "looking outward, straight ahead in the middle" : "looking outward";
  return fmt::format("{} rings x {} columns, {}", strip.image.height, strip.columns, how);
}

}  // namespace scanmill
