#include "viewer/range_strip.h"

#include <fmt/core.h>

#include <complex>
#include <numeric>

#include "base/error.h"
#include "base/vec.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

// The azimuths of all beams. The azimuth of a beam is first + offset[ring] + step * column (rad).
struct BeamAzimuths {
  double first = 0;            // azimuth of column 0 (rad)
  std::vector<double> offset;  // azimuth of each ring relative to the column (rad)
  double step = 0;             // angle from column to column (rad); negative if the sensor rotates clockwise
  bool fullTurn = false;       // true: a full revolution, where the first column follows the last
};

// Sums over pairs (x, y), from which covariance() and spread() are computed.
struct PairSums {
  double x = 0, y = 0, xx = 0, yy = 0, xy = 0, count = 0;

  void add(double newX, double newY) {
    x += newX;
    y += newY;
    xx += newX * newX;
    yy += newY * newY;
    xy += newX * newY;
    count += 1;
  }
  double covariance() const { return xy * count - x * y; }  // the covariance, times the square of `count`
  // Returns the product of the standard deviations, times the square of `count`.
  double spread() const { return std::sqrt((xx * count - x * x) * (yy * count - y * y)); }
};

struct GridSize {
  std::size_t rings = 1, columns = 1;
};

// Maps beams to the pixel columns of a range image that looks outward: the image is destaggered, mirrored if the sensor
// rotates counter-clockwise, and rotated if it shows a full revolution.
struct OutwardColumns {
  Destagger image;
  bool mirrored = false;
  std::size_t start = 0;  // pixel column of column 0 of the destaggered image

  std::size_t pixelColumn(std::size_t ring, std::size_t column) const {
    const std::size_t shifted = image.columnOf(ring, static_cast<std::uint32_t>(column));
    return (start + (mirrored ? image.width - shifted : shifted)) % image.width;
  }
};

// Unit vectors of the x-y plane in the directions of the beams, indexed by ring * columns + column; 0: not known.
using Directions = std::vector<std::complex<float>>;

// Returns the directions of all beams if the beam table fits the scan's grid, otherwise the directions of the points.
Directions directionsOf(const Scan& scan, const GridSize& grid, const BeamTable* beams) {
  constexpr double kOnAxis = 1e-3;  // points nearer to the z axis than this (m) have no meaningful azimuth
  Directions directions(grid.rings * grid.columns);
  const auto setDirection = [&](std::size_t beam, const Vec3d& p) {
    const double distance = std::hypot(p.x, p.y);
    if (!std::isfinite(distance) || distance <= kOnAxis) return;
    directions[beam] = std::complex<float>(std::complex(p.x, p.y) / distance);
  };
  if (beams != nullptr && beams->columns == grid.columns && beams->direction.size() == directions.size()) {
    for (std::size_t beam = 0; beam < directions.size(); ++beam) setDirection(beam, beams->direction[beam]);
  } else {
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const PointKey key = keyOf(scan, i);
      setDirection(key.ring * grid.columns + key.column, Vec3d(scan.position[i]));
    }
  }
  return directions;
}

// Returns the mean angle from column to column (rad); 0 if there are too few beams. Pairs of beams at growing distances
// in a ring refine the angle.
double stepOf(const Directions& directions, std::size_t columns) {
  constexpr std::size_t kLeastPairs = 16;
  double step = 0;
  for (std::size_t distance = 1; distance <= std::max<std::size_t>(columns / 4, 1); distance *= 4) {  // in columns
    std::complex<double> sum;  // sum of the rotations from beam to beam, as unit vectors
    std::size_t pairs = 0;
    for (std::size_t beam = 0; beam + distance < directions.size(); ++beam) {
      if (beam % columns + distance >= columns) continue;
      const std::complex<double> rotation = directions[beam + distance] * std::conj(directions[beam]);
      sum += rotation;
      pairs += rotation == 0.0 ? 0 : 1;
    }
    const auto steps = static_cast<double>(distance);
    if (pairs >= kLeastPairs) step += std::arg(sum * std::polar(1.0, -step * steps)) / steps;
  }
  return step;
}

// Returns the azimuths of the beams if the columns form a full turn and are evenly spaced, with a constant offset for
// each ring; otherwise nothing. `step`: mean angle from column to column (rad).
std::optional<BeamAzimuths> fullTurnOf(const Directions& directions, const GridSize& grid, double step) {
  // Fraction by which the angle of a full turn may differ from 2 pi, since the vehicle may turn during the revolution.
  constexpr double kTurnSlack = 0.03;
  constexpr double kLeastAgreement = 0.8;  // least ratio of the lengths of `sums` to the number of unit vectors
  const double fullStep = std::copysign(2 * kPi / static_cast<double>(grid.columns), step);
  std::vector<std::complex<double>> sums(grid.rings);  // sums of directions, rotated back by their columns' azimuths
  double count = 0;
  for (std::size_t beam = 0; beam < directions.size(); ++beam) {
    const std::complex<double> direction = directions[beam];
    sums[beam / grid.columns] += direction * std::polar(1.0, -fullStep * static_cast<double>(beam % grid.columns));
    count += direction == 0.0 ? 0 : 1;
  }
  double agreement = 0;
  for (const std::complex<double>& sum : sums) agreement += std::abs(sum);
  if (!(std::abs(step / fullStep - 1) < kTurnSlack && agreement >= kLeastAgreement * count)) return {};
  const double first = std::arg(std::accumulate(sums.begin(), sums.end(), std::complex<double>()));
  BeamAzimuths azimuths{.first = first, .offset = std::vector<double>(grid.rings), .step = fullStep, .fullTurn = true};
  for (std::size_t ring = 0; ring < grid.rings; ++ring) {
    if (std::abs(sums[ring]) > 0) azimuths.offset[ring] = wrapped(std::arg(sums[ring]) - first);
  }
  return azimuths;
}

// True if the azimuth increases (step > 0) or decreases (step < 0) with the column.
bool followsColumns(const Directions& directions, std::size_t columns, double step) {
  constexpr double kCorrelated = 0.5;  // least correlation of azimuth and column
  std::complex<double> middle;
  for (const std::complex<float>& direction : directions) middle += std::complex<double>(direction);
  PairSums sums;  // x: azimuth (rad, relative to the middle of all directions); y: column
  for (std::size_t beam = 0; beam < directions.size(); ++beam) {
    const std::complex<double> direction = directions[beam];
    if (direction == 0.0) continue;
    sums.add(std::arg(direction * std::conj(middle)), static_cast<double>(beam % columns));
  }
  return std::copysign(1.0, step) * sums.covariance() > kCorrelated * sums.spread();
}

// Returns azimuths estimated from directions: the result of fullTurnOf() or, if the columns form no full turn, azimuths
// without offsets of rings. Returns nothing if azimuths neither increase nor decrease with the column.
std::optional<BeamAzimuths> estimateAzimuths(const Directions& directions, const GridSize& grid) {
  const double step = stepOf(directions, grid.columns);
  if (step == 0) return {};
  if (auto turn = fullTurnOf(directions, grid, step)) return turn;
  if (!followsColumns(directions, grid.columns, step)) return {};
  return BeamAzimuths{.offset = std::vector<double>(grid.rings), .step = step};
}

// Returns the azimuths of the beams: those of the sensor's beam table `beams` if it has the scan's rings and columns
// and its rings are cones, otherwise those of estimateAzimuths().
std::optional<BeamAzimuths> beamAzimuths(const Scan& scan, const GridSize& grid, const BeamTable* beams) {
  const bool onCones = beams != nullptr && beams->azimuthOffset.size() == grid.rings && beams->onCones() &&
                       beams->rings == grid.rings && beams->columns == grid.columns;
  if (!onCones || grid.columns < 2) return estimateAzimuths(directionsOf(scan, grid, beams), grid);
  const auto lastColumn = static_cast<std::uint32_t>(grid.columns - 1);
  return BeamAzimuths{.first = beams->azimuth(0),
                      .offset = beams->azimuthOffset,
                      .step = (beams->azimuth(lastColumn) - beams->azimuth(0)) / lastColumn,
                      .fullTurn = beams->fullTurn()};
}

// Returns the pixel columns of the beams such that the left side of the image shows what is on the sensor's left. If
// the field of view is a full revolution, the middle of the image shows straight ahead. Returns nothing if the azimuths
// of two rings differ so much that their rows would not overlap.
std::optional<OutwardColumns> lookingOutward(const BeamAzimuths& azimuths, std::size_t columns) {
  OutwardColumns outward;
  outward.image = destagger(azimuths.offset, azimuths.step, static_cast<std::uint32_t>(columns), azimuths.fullTurn);
  outward.mirrored = azimuths.step > 0;
  if (outward.image.width >= 2 * columns) return {};
  if (azimuths.fullTurn) {
    const auto width = static_cast<std::ptrdiff_t>(columns);
    const std::ptrdiff_t start = width / 2 - std::lround(wrapped(azimuths.first) / std::abs(azimuths.step));
    outward.start = static_cast<std::size_t>((start % width + width) % width);
  } else if (outward.mirrored) {
    outward.start = outward.image.width - 1;
  }
  return outward;
}

// True if elevations increase with the ring number, determined by the sign of their covariance.
bool elevationsRise(const Scan& scan) {
  PairSums sums;  // x: ring; y: elevation (rad)
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3d p(scan.position[i]);
    if (isFinite(p)) sums.add(static_cast<double>(keyOf(scan, i).ring), std::atan2(p.z, std::hypot(p.x, p.y)));
  }
  return sums.covariance() > 0;
}

// Returns the scan's numbers of rings and columns; if it is not organised, at least as many as its points need. Throws
// InputError if it is not organised and lacks `ring` or `column`, or if a number exceeds kMostPictureSide.
GridSize gridOf(const Scan& scan) {
  GridSize size{std::max<std::size_t>(scan.rings, 1), std::max<std::size_t>(scan.columns, 1)};
  if (!scan.organised) {
    for (const auto& [name, missing] : {std::pair{"ring", scan[kRing].empty()}, {"column", scan[kColumn].empty()}}) {
      if (missing && scan.size() > 0) {
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
  const auto azimuths = beamAzimuths(scan, grid, beams);
  const auto outward = azimuths ? lookingOutward(*azimuths, grid.columns) : std::nullopt;
  strip.outward = outward && outward->image.width <= kMostPictureSide;
  strip.fullTurn = strip.outward && azimuths->fullTurn;
  const std::size_t width = strip.outward ? outward->image.width : grid.columns;
  strip.image = Image(static_cast<int>(width), static_cast<int>(grid.rings), kBackground);
  strip.ringsRise = elevationsRise(scan);
  strip.pointAt.assign(strip.image.pixels.size(), kNoPoint);
  strip.pixelOf.resize(scan.size());
  std::vector<double> nearest(strip.image.pixels.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    const std::size_t row = strip.ringsRise ? grid.rings - 1 - key.ring : key.ring;
    const std::size_t pixel = row * width + (strip.outward ? outward->pixelColumn(key.ring, key.column) : key.column);
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
  const char* const order = !strip.outward   ? "in the sensor's order: its columns do not follow the azimuth"
                            : strip.fullTurn ? "looking outward, straight ahead in the middle"
                                             : "looking outward";
  return fmt::format("{} rings x {} columns, {}", strip.image.height, strip.columns, order);
}

}  // namespace scanmill
