#include "viewer/range_strip.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "base/vec.h"
#include "evaluate/spread.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

// The azimuths of all beams. The azimuth of a beam is first + offset[ring] + step * column (rad).
struct StripColumns {
  double first = 0;            // azimuth of column 0 (rad)
  std::vector<double> offset;  // azimuth of each ring relative to the column (rad)
  double step = 0;             // angle from column to column (rad); negative if the sensor rotates clockwise
  bool fullTurn = false;       // true: a full revolution, where the first column follows the last
};

// The pixels of beams in a range image that looks outward: the image is destaggered, mirrored if the sensor rotates
// counter-clockwise, and rotated in a full revolution.
struct StripPlaces {
  Destagger image;
  bool mirrored = false;
  std::size_t start = 0;  // pixel column of column 0 of the destaggered image

  std::size_t place(std::size_t ring, std::size_t column) const {
    const std::size_t c = image.place(ring, static_cast<std::uint32_t>(column));
    return (start + (mirrored ? image.width - c : c)) % image.width;
  }
};

double wrapped(double angle) {
  return std::remainder(angle, 2 * kPi);
}

// The azimuths of the beams that have a hit, by ring and column.
class AzimuthGrid {
 public:
  AzimuthGrid(const Scan& scan, const std::vector<std::size_t>& ring, const std::vector<std::size_t>& column,
              std::size_t rings, std::size_t columns)
      : rings_(rings), columns_(columns), azimuth_(rings * columns, std::numeric_limits<float>::quiet_NaN()) {
    constexpr double kOnAxis = 1e-3;  // points nearer to the z axis than this (m) have no meaningful azimuth
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const Vec3f& p = scan.position[i];
      if (!isFinite(p) || !(std::hypot(p.x, p.y) > kOnAxis)) continue;
      azimuth_[ring[i] * columns + column[i]] = std::atan2(p.y, p.x);
    }
  }

  // Calls visit(ring, column, azimuth) for each beam that has an azimuth (rad).
  void each(const auto& visit) const {
    for (std::size_t r = 0; r < rings_; ++r) {
      for (std::size_t c = 0; c < columns_; ++c) {
        if (const float a = azimuth_[r * columns_ + c]; std::isfinite(a)) visit(r, c, double{a});
      }
    }
  }

  // Returns the differences between measured azimuth steps per column and the estimate `roughly` (rad). Each step is
  // measured between two beams of a ring that are `apart` columns apart.
  std::vector<double> turns(std::size_t apart, double roughly) const {
    constexpr std::size_t kEnough = 100'000;
    const std::size_t stride = std::max<std::size_t>(azimuth_.size() / kEnough, 1);
    const auto span = static_cast<double>(apart);
    std::vector<double> out;
    for (std::size_t i = 0; i < azimuth_.size(); i += stride) {
      if (i % columns_ + apart >= columns_) continue;
      const double turned = double{azimuth_[i + apart]} - double{azimuth_[i]};
      if (std::isfinite(turned)) out.push_back(wrapped(turned - roughly * span) / span);
    }
    return out;
  }

 private:
  std::size_t rings_;
  std::size_t columns_;
  std::vector<float> azimuth_;  // azimuth of each beam (rad); NaN: no hit, or a hit on the z axis
};

std::optional<StripColumns> estimated(const AzimuthGrid& grid, std::size_t rings, std::size_t columns) {
  constexpr std::size_t kLeastPairs = 16;
  // Largest difference of a full turn's sweep from 2 pi, as a fraction of 2 pi, since the vehicle may turn meanwhile.
  constexpr double kTurnSlack = 0.03;
  StripColumns look;
  std::vector<double> turns = grid.turns(1, 0);
  if (turns.size() < kLeastPairs) return {};
  look.step = medianOf(turns);
  // Beams that are farther apart determine the step more exactly.
  for (std::size_t apart = 4; apart <= columns / 4; apart *= 4) {
    turns = grid.turns(apart, look.step);
    if (turns.size() >= kLeastPairs) look.step += medianOf(turns);
  }
  const double swept = std::abs(look.step) * static_cast<double>(columns);
  if (!(look.step != 0) || swept > 2 * kPi * (1 + kTurnSlack)) return {};
  look.fullTurn = swept > 2 * kPi * (1 - kTurnSlack);
  if (look.fullTurn) look.step = std::copysign(2 * kPi / static_cast<double>(columns), look.step);

  const auto strayOf = [&](std::size_t column, double azimuth) {
    return azimuth - look.step * static_cast<double>(column);
  };
  Vec3d sum;
  grid.each([&](std::size_t, std::size_t c, double azimuth) {
    const double stray = strayOf(c, azimuth);
    sum += Vec3d{std::cos(stray), std::sin(stray), 0};
  });
  const double usual = std::atan2(sum.y, sum.x);
  std::vector<std::vector<double>> strays(rings);
  grid.each(
      [&](std::size_t r, std::size_t c, double azimuth) { strays[r].push_back(wrapped(strayOf(c, azimuth) - usual)); });
  look.offset.assign(rings, 0);
  std::vector<double> known;  // offsets from `usual` of the rings that have points
  std::size_t count = 0;
  std::size_t near = 0;
  const double reach = std::max(2.5 * std::abs(look.step), radians(5));
  for (std::size_t r = 0; r < rings; ++r) {
    if (strays[r].empty()) continue;
    const double offset = medianOf(strays[r]);
    known.push_back(offset);
    look.offset[r] = offset;
    count += strays[r].size();
    near += static_cast<std::size_t>(
        std::ranges::count_if(strays[r], [&](double s) { return std::abs(s - offset) <= reach; }));
  }
  const double middle = medianOf(known);
  look.first = usual + middle;
  for (std::size_t r = 0; r < rings; ++r) look.offset[r] = strays[r].empty() ? 0 : look.offset[r] - middle;
  constexpr double kFollowing = 0.6;  // least fraction of all points that must be near the azimuths of their rings
  if (static_cast<double>(near) >= kFollowing * static_cast<double>(count)) return look;
  // If too few points are near these azimuths, the columns may be those of a camera image, whose azimuths are not
  // evenly spaced. The rings of such an image are not shifted.
  constexpr double kOneWay = 0.9;  // least fraction of the steps that must have the same direction
  turns = grid.turns(1, 0);
  const auto along = std::ranges::count_if(turns, [&](double t) { return t * look.step > 0; });
  if (look.fullTurn || static_cast<double>(along) < kOneWay * static_cast<double>(turns.size())) return {};
  look.offset.assign(rings, 0);
  return look;
}

// Returns the azimuths of the beams. They are taken from the sensor's beam table `beams` if it has `rings` rings and
// `columns` columns and its rings are cones; otherwise they are estimated from the points. The estimated step is the
// median of the steps between neighbouring columns. The estimated offset of a ring is the median of (azimuth - first -
// step * column) over its points, so that a few near or noisy points have no influence. If azimuths increase or
// decrease steadily but not evenly, as in a camera image, all offsets are 0. Returns nothing if there are too
// few points, or if azimuths neither increase nor decrease with the column. `ring` and `column`: one per point.
std::optional<StripColumns> stripColumns(const Scan& scan, const std::vector<std::size_t>& ring,
                                         const std::vector<std::size_t>& column, std::size_t rings, std::size_t columns,
                                         const BeamTable* beams) {
  const bool onCones = beams != nullptr && beams->listed == nullptr && !beams->rosette;
  if (!onCones || beams->rings != rings || beams->columns != columns || beams->azimuthOffset.size() != rings ||
      columns < 2) {
    return estimated(AzimuthGrid(scan, ring, column, rings, columns), rings, columns);
  }
  StripColumns look;
  look.step =
      (beams->azimuth(static_cast<std::uint32_t>(columns - 1)) - beams->azimuth(0)) / static_cast<double>(columns - 1);
  look.fullTurn = beams->fullTurn();
  look.first = beams->azimuth(0);
  look.offset = beams->azimuthOffset;
  return look;
}

// Returns the places of the beams such that the left side of the image shows what is on the sensor's left. If the field
// of view is a full revolution, the middle of the image shows straight ahead. Returns nothing if the azimuths of two
// rings differ so much that their rows would not overlap.
std::optional<StripPlaces> lookingOutward(const StripColumns& look, std::size_t columns) {
  StripPlaces places;
  places.image = destagger(look.offset, look.step, static_cast<std::uint32_t>(columns), look.fullTurn);
  places.mirrored = look.step > 0;
  if (places.image.width >= 2 * columns) return {};
  if (look.fullTurn) {
    const auto width = static_cast<std::ptrdiff_t>(columns);
    const std::ptrdiff_t start = width / 2 - std::lround(wrapped(look.first) / std::abs(look.step));
    places.start = static_cast<std::size_t>((start % width + width) % width);
  } else if (places.mirrored) {
    places.start = places.image.width - 1;
  }
  return places;
}

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
