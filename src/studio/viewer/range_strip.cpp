#include "viewer/range_strip.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "base/vec.h"
#include "viewer/color_map.h"
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

struct GridSize {
  std::size_t rings = 1, columns = 1;
};

// The pixels of beams in a range image that looks outward: the image is destaggered, mirrored if the sensor rotates
// counter-clockwise, and rotated in a full revolution.
struct OutwardColumns {
  Destagger image;
  bool mirrored = false;
  std::size_t start = 0;  // pixel column of column 0 of the destaggered image

  std::size_t pixelColumn(std::size_t ring, std::size_t column) const {
    const std::size_t c = image.columnOf(ring, static_cast<std::uint32_t>(column));
    return (start + (mirrored ? image.width - c : c)) % image.width;
  }
};

// Unit vectors of the x-y plane in the directions of the beams, indexed by ring * columns + column; 0: not known.
using Directions = std::vector<std::complex<float>>;

// Returns the directions of all beams, if the beam table has the scan's rings and columns, otherwise those of the
// points. `ring` and `column`: one per point.
Directions directionsOf(const Scan& scan, const std::vector<std::size_t>& ring, const std::vector<std::size_t>& column,
                        const GridSize& grid, const BeamTable* beams) {
  constexpr double kOnAxis = 1e-3;  // points nearer to the z axis than this (m) have no meaningful azimuth
  Directions all(grid.rings * grid.columns);
  const auto put = [&](std::size_t beam, const Vec3d& p) {
    const double away = std::hypot(p.x, p.y);
    if (std::isfinite(away) && away > kOnAxis) all[beam] = std::complex<float>(std::complex(p.x, p.y) / away);
  };
  if (beams != nullptr && beams->columns == grid.columns && beams->direction.size() == all.size()) {
    for (std::size_t beam = 0; beam < all.size(); ++beam) put(beam, beams->direction[beam]);
  } else {
    for (std::size_t i = 0; i < scan.size(); ++i) put(ring[i] * grid.columns + column[i], Vec3d(scan.position[i]));
  }
  return all;
}

// Returns the mean angle from column to column (rad), refined by beams of a ring that are farther and farther apart; 0
// if there are too few beams.
double stepOf(const Directions& directions, std::size_t columns) {
  constexpr std::size_t kLeast = 16;  // least number of pairs of beams
  double step = 0;
  for (std::size_t apart = 1; apart <= std::max<std::size_t>(columns / 4, 1); apart *= 4) {
    std::complex<double> turned;  // sum of the unit vectors of all turns from beam to beam
    std::size_t pairs = 0;
    for (std::size_t beam = 0; beam + apart < directions.size(); ++beam) {
      if (beam % columns + apart >= columns) continue;
      const std::complex<double> turn = directions[beam + apart] * std::conj(directions[beam]);
      turned += turn;
      pairs += turn == 0.0 ? 0 : 1;
    }
    const auto columnsApart = static_cast<double>(apart);
    if (pairs >= kLeast) step += std::arg(turned * std::polar(1.0, -step * columnsApart)) / columnsApart;
  }
  return step;
}

// Returns the azimuths that the directions show if the columns, which have the given mean step (rad), are a full turn,
// and each ring's azimuths differ from evenly spaced ones by nearly a constant, the ring's offset.
std::optional<BeamAzimuths> fullTurnOf(const Directions& directions, const GridSize& grid, double step) {
  // Largest difference of a full turn's sweep from 2 pi, as a fraction of 2 pi, since the vehicle may turn meanwhile.
  constexpr double kTurnSlack = 0.03;
  constexpr double kLeastAgreement = 0.8;  // least mean length of a ring's sum of unit vectors; 1: all are equal
  const double fullStep = std::copysign(2 * kPi / static_cast<double>(grid.columns), step);
  std::vector<std::complex<double>> sums(grid.rings);
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
  BeamAzimuths azimuths{first, std::vector<double>(grid.rings), fullStep, true};
  for (std::size_t r = 0; r < grid.rings; ++r) {
    if (std::abs(sums[r]) > 0) azimuths.offset[r] = wrapped(std::arg(sums[r]) - first);
  }
  return azimuths;
}

// True if the azimuth increases (step > 0) or decreases (step < 0) with the column.
bool followsColumns(const Directions& directions, std::size_t columns, double step) {
  constexpr double kCorrelated = 0.5;  // least correlation of azimuth and column
  std::complex<double> middle;
  for (const std::complex<float>& direction : directions) middle += std::complex<double>(direction);
  double sumA = 0, sumC = 0, sumAA = 0, sumCC = 0, sumAC = 0, count = 0;
  for (std::size_t beam = 0; beam < directions.size(); ++beam) {
    const std::complex<double> direction = directions[beam];
    if (direction == 0.0) continue;
    const double a = std::arg(direction * std::conj(middle));
    const auto c = static_cast<double>(beam % columns);
    sumA += a;
    sumC += c;
    sumAA += a * a;
    sumCC += c * c;
    sumAC += a * c;
    ++count;
  }
  const double covariance = sumAC * count - sumA * sumC;
  const double spread = std::sqrt((sumAA * count - sumA * sumA) * (sumCC * count - sumC * sumC));
  return std::copysign(1.0, step) * covariance > kCorrelated * spread;
}

// Returns the azimuths that the directions show: those of a full turn, otherwise rings that are not shifted. Returns
// nothing if azimuths neither increase nor decrease with the column.
std::optional<BeamAzimuths> estimated(const Directions& directions, const GridSize& grid) {
  const double step = stepOf(directions, grid.columns);
  if (step == 0) return {};
  if (auto turn = fullTurnOf(directions, grid, step)) return turn;
  if (!followsColumns(directions, grid.columns, step)) return {};
  return BeamAzimuths{.offset = std::vector<double>(grid.rings), .step = step};
}

// Returns the azimuths of the beams: those of the sensor's beam table `beams` if it has the scan's rings and columns
// and its rings are cones, otherwise those of estimated().
std::optional<BeamAzimuths> beamAzimuths(const Scan& scan, const std::vector<std::size_t>& ring,
                                         const std::vector<std::size_t>& column, const GridSize& grid,
                                         const BeamTable* beams) {
  const bool onCones = beams != nullptr && beams->azimuthOffset.size() == grid.rings && beams->onCones() &&
                       beams->rings == grid.rings && beams->columns == grid.columns;
  if (!onCones || grid.columns < 2) return estimated(directionsOf(scan, ring, column, grid, beams), grid);
  BeamAzimuths azimuths;
  azimuths.step = (beams->azimuth(static_cast<std::uint32_t>(grid.columns - 1)) - beams->azimuth(0)) /
                  static_cast<double>(grid.columns - 1);
  azimuths.fullTurn = beams->fullTurn();
  azimuths.first = beams->azimuth(0);
  azimuths.offset = beams->azimuthOffset;
  return azimuths;
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
  const auto azimuths = beamAzimuths(scan, ring, column, grid, beams);
  const auto outward = azimuths ? lookingOutward(*azimuths, grid.columns) : std::nullopt;
  if (outward && outward->image.width <= kMostPictureSide) {
    for (std::size_t i = 0; i < scan.size(); ++i) column[i] = outward->pixelColumn(ring[i], column[i]);
    width = outward->image.width;
    strip.outward = true;
    strip.fullTurn = azimuths->fullTurn;
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
