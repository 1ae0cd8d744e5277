#include "study/noise/flat_patches.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "base/parallel.h"
#include "evaluate/spread.h"
#include "study/linear_fit.h"

namespace scanmill {

namespace {

constexpr std::size_t kCells = std::size_t{kPatchRings} * kPatchColumns;
constexpr std::uint32_t kColumnStep = 3;     // columns from one examined window to the next
constexpr double kReturned = 0.6;            // least fraction of the tested half that must have returns
constexpr std::size_t kFewestMeasured = 14;  // least number of returns in the measured half
constexpr double kFewestFreedom = 6;
// Least cosine of the incidence angle of a patch; more grazing views say little about noise.
constexpr double kEdgeOn = 0.02;
constexpr double kDeepest = 3;  // largest ratio between the farthest and the nearest range in a patch
// Largest RMS deviation of a patch from its plane, as a multiple of the group's noise.
constexpr double kPlaneTolerance = 3;
// Largest distance of the points around a possible hole from the patch's plane, as a multiple of the patch's deviation.
constexpr double kOnPlane = 4;
constexpr std::size_t kTelling = 100;     // least number of windows in a group for a meaningful quantile
constexpr double kTenth = -1.2815515655;  // 10 % quantile of the standard normal distribution
// 99 % quantile of the standard normal distribution. A patch is not used if its noise exceeds the 99 % quantile that
// follows from the group's usual noise.
constexpr double kMostNoise = 2.3263478740;

// One beam of a patch's window, with its position in the window and its measured range.
struct Cell {
  std::uint32_t row = 0, column = 0, beam = 0;
  bool tested = false;
  bool returned = false;
  double range = 0;  // measured range (m); NaN if the beam has no return
};

using Cells = std::array<Cell, kCells>;

// Returns the beams of a window, row by row; nothing if a ring has no beam in a column of the window.
std::optional<Cells> cellsOf(const BeamImage& image, const RecordedScan& scan, const PatchWindow& window) {
  Cells cells;
  for (std::size_t i = 0; i < kCells; ++i) {
    Cell& cell = cells[i];
    cell.row = static_cast<std::uint32_t>(i / kPatchColumns);
    cell.column = static_cast<std::uint32_t>(i % kPatchColumns);
    const auto beam = image.beam(window.row + cell.row, window.column + cell.column);
    if (!beam) return {};
    cell.beam = *beam;
    cell.tested = (window.row + cell.row + window.column + cell.column) % 2 == window.tested;
    cell.range = scan.range[*beam];
    cell.returned = !std::isnan(cell.range);
  }
  return cells;
}

// Returns the beams with a return in the tested half of the window if `tested` is true, else in the measured half.
std::vector<const Cell*> returnsOfHalf(const Cells& cells, bool tested) {
  std::vector<const Cell*> returns;
  for (const Cell& cell : cells) {
    if (cell.returned && cell.tested == tested) returns.push_back(&cell);
  }
  return returns;
}

struct PlaneFit {
  PatchPlane plane;
  SurfaceFit fit;  // fit of the ranges along the beams
};

// Fits a plane by least squares of the range differences along the beams. First solves dot(plane, point) = 1, which is
// linear in the plane but weights points by incidence; then Gauss-Newton steps minimise the range differences
// themselves. `cells`: beams with a return. Returns nothing if the points do not determine a plane, or if a beam does
// not hit the plane.
std::optional<PlaneFit> fitPlane(const BeamTable& beams, const std::vector<const Cell*>& cells) {
  std::vector<double> design, values;
  for (const Cell* cell : cells) {
    const Vec3d p = beams.originOf(cell->beam) + beams.direction[cell->beam] * cell->range;
    design.insert(design.end(), {p.x / cell->range, p.y / cell->range, p.z / cell->range});
    values.push_back(1 / cell->range);
  }
  LinearFit fit = fitLinear(design, 3, values);
  if (fit.rank < 3) return {};
  PatchPlane plane{fit.coefficients[0], fit.coefficients[1], fit.coefficients[2]};
  constexpr int kSteps = 2;
  for (int step = 0; step <= kSteps; ++step) {
    design.clear();
    values.clear();
    for (const Cell* cell : cells) {
      const Vec3d& u = beams.direction[cell->beam];
      const double slope = dot(plane, u);
      const double range = rangeOnPlane(beams, cell->beam, plane);
      if (!(range > 0)) return {};
      const Vec3d p = beams.originOf(cell->beam) + u * range;
      design.insert(design.end(), {-p.x / slope, -p.y / slope, -p.z / slope});
      values.push_back(cell->range - range);
    }
    fit = fitLinear(design, 3, values);
    if (fit.rank < 3) return {};
    // After the last step, `fit` only measures the range differences that remain.
    if (step < kSteps) plane += Vec3d{fit.coefficients[0], fit.coefficients[1], fit.coefficients[2]};
  }
  return PlaneFit{plane, {fit.squares, fit.freedom()}};
}

// Fits the differences between the ranges and the plane by a model: an offset and a slope for each ring, where the
// slope changes linearly from ring to ring, and a square and a cubic term for the curvature, common to all rings.
// Returns the fit with its residuals.
LinearFit fitLines(const BeamTable& beams, const std::vector<const Cell*>& cells, const PatchPlane& plane) {
  constexpr std::size_t kTerms = kPatchRings + 4;
  std::vector<double> design(cells.size() * kTerms, 0.0);
  std::vector<double> values;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = *cells[i];
    double* const row = design.data() + i * kTerms;
    const double x = 2.0 * cell.column / (kPatchColumns - 1) - 1;
    const double y = 2.0 * cell.row / (kPatchRings - 1) - 1;
    row[cell.row] = 1;
    row[kPatchRings] = x;
    row[kPatchRings + 1] = x * x;
    row[kPatchRings + 2] = x * x * x;
    row[kPatchRings + 3] = x * y;
    values.push_back(cell.range - rangeOnPlane(beams, cell.beam, plane));
  }
  return fitLinear(design, kTerms, values);
}

// Counts enclosed beams and holes. A measured beam inside of the window is enclosed if at least three of its four
// neighbours, all of which are tested beams, have returns, and all these returns lie on the patch's plane. An enclosed
// beam without a return is a hole. `deviation`: standard deviation of the tested half from the plane (m).
void countHoles(const BeamTable& beams, const Cells& cells, double deviation, FlatPatch& patch) {
  for (const Cell& cell : cells) {
    const bool isInside =
        cell.row > 0 && cell.row + 1 < kPatchRings && cell.column > 0 && cell.column + 1 < kPatchColumns;
    if (cell.tested || !isInside) continue;
    const std::size_t index = std::size_t{cell.row} * kPatchColumns + cell.column;
    int returns = 0;
    bool allOnPlane = true;
    for (const std::size_t neighbourIndex : {index - kPatchColumns, index - 1, index + 1, index + kPatchColumns}) {
      const Cell& neighbour = cells[neighbourIndex];
      if (!neighbour.returned) continue;
      ++returns;
      const double distance = neighbour.range - rangeOnPlane(beams, neighbour.beam, patch.plane);
      if (std::abs(distance) > kOnPlane * deviation) allOnPlane = false;
    }
    if (returns < 3 || !allOnPlane) continue;
    ++patch.enclosed;
    patch.holes += cell.returned ? 0u : 1u;
  }
}

// Returns the index of a group. Windows of similar range and incidence form a group and are compared.
std::size_t groupIn(std::size_t rangeBand, bool grazing) {
  return 2 * rangeBand + (grazing ? 1 : 0);
}
std::size_t groupOf(const FlatPatch& patch) {
  return groupIn(rangeBandOf(patch.range), patch.incidence < kSteep);
}

// Returns the standard deviation (m) of flat windows for each group, taken from the group's smoothest tenth since most
// windows may not be flat. A group may even have no flat window, so neighbouring range bands bound the value: noise
// does not decrease with range, and grows at most with the squared range, as the returned power decreases. Bounds that
// are too tight reduce the number of patches, but cause no bias: the choice does not depend on the measured halves.
std::vector<double> usualDeviations(const std::vector<FlatPatch>& candidates) {
  const std::size_t bands = rangeBandEdges().size(), groups = 2 * bands;
  // By group, the noise variance that each window implies if the window's variance is the group's 10 % quantile, since
  // this quantile is chosen below. A group with fewer than kTelling windows does not bound other groups.
  std::vector<std::vector<double>> impliedVariances(groups);
  std::vector<std::vector<double>> ranges(groups);
  for (const FlatPatch& p : candidates) {
    const std::size_t group = groupOf(p);
    impliedVariances[group].push_back(p.testedLines.variance() / chiSquareQuantile(p.testedLines.freedom, kTenth));
    ranges[group].push_back(p.range);
  }
  std::vector<double> usual(groups, 0.0);
  for (const bool grazing : {false, true}) {
    // Noise does not decrease with range: from far to near, a band gets at most the deviation of farther bands.
    double fartherDeviation = INFINITY;
    for (std::size_t band = bands; band-- > 0;) {
      const std::size_t group = groupIn(band, grazing);
      std::vector<double>& v = impliedVariances[group];
      if (v.empty()) continue;
      const auto tenth = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 10);
      std::nth_element(v.begin(), tenth, v.end());
      usual[group] = std::min(fartherDeviation, std::sqrt(*tenth));
      if (v.size() >= kTelling) fartherDeviation = usual[group];
    }
    // Noise grows at most with the squared range: from near to far, a band gets at most the bound of nearer bands.
    double nearerRange = 0;
    double nearerDeviation = 0;
    for (std::size_t band = 0; band < bands; ++band) {
      const std::size_t group = groupIn(band, grazing);
      if (impliedVariances[group].empty()) continue;
      const double range = medianOf(ranges[group]);
      const double growth = range / nearerRange;
      if (nearerRange > 0) usual[group] = std::min(usual[group], nearerDeviation * growth * growth);
      if (impliedVariances[group].size() < kTelling) continue;
      nearerRange = range;
      nearerDeviation = usual[group];
    }
  }
  return usual;
}

// Returns the candidates that are flat and do not overlap a chosen window. `candidates`: sorted by scan, then by colour
// of the tested beams, then in raster order. `usualOfGroup`: the result of usualDeviations().
std::vector<FlatPatch> chooseFlat(const std::vector<FlatPatch>& candidates, const std::vector<double>& usualOfGroup,
                                  const BeamImage& image) {
  std::vector<FlatPatch> chosen;
  std::vector<bool> taken(std::size_t{image.rows()} * image.columns());
  const FlatPatch* previous = nullptr;
  for (const FlatPatch& patch : candidates) {
    const PatchWindow& w = patch.window;
    if (previous == nullptr || previous->window.scan != w.scan || previous->window.tested != w.tested) {
      taken.assign(taken.size(), false);
    }
    previous = &patch;
    const double usual = usualOfGroup[groupOf(patch)];
    const double freedom = patch.testedLines.freedom;
    const double limit = usual * usual * chiSquareQuantile(freedom, kMostNoise) * freedom;
    if (patch.testedLines.squares > limit || patch.testedPlaneDeviation > kPlaneTolerance * usual) continue;
    std::vector<std::size_t> pixels;
    for (std::size_t i = 0; i < kCells; ++i) {
      const std::size_t column = (w.column + i % kPatchColumns) % image.columns();
      pixels.push_back((w.row + i / kPatchColumns) * image.columns() + column);
    }
    if (std::ranges::any_of(pixels, [&](std::size_t pixel) { return taken[pixel]; })) continue;
    for (const std::size_t pixel : pixels) taken[pixel] = true;
    chosen.push_back(patch);
  }
  return chosen;
}

// Sets the measured half's fits and number of points. Does nothing if the returns are too few or determine no plane.
void addMeasuredHalf(const BeamTable& beams, const std::vector<const Cell*>& measured, FlatPatch& patch) {
  constexpr double kLeastFree = 0.1;  // returns with a smaller value of 1 - leverage do not count
  if (measured.size() < kFewestMeasured) return;
  const LinearFit lines = fitLines(beams, measured, patch.plane);
  const std::optional<PlaneFit> plane = fitPlane(beams, measured);
  if (lines.freedom() < kFewestFreedom || !plane) return;
  patch.measuredLines = {lines.squares, lines.freedom()};
  patch.measuredPlane = plane->fit;
  const auto points = std::ranges::count_if(lines.leverages, [](double leverage) { return 1 - leverage > kLeastFree; });
  patch.points = static_cast<std::uint32_t>(points);
}

// Measures one window, flat or not. Returns nothing if the window has too few returns, if its ranges differ too much,
// or if its plane is seen edge-on or from behind.
std::optional<FlatPatch> measurePatch(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan,
                                      const PatchWindow& window) {
  const std::optional<Cells> cells = cellsOf(image, scan, window);
  if (!cells) return {};
  const std::vector<const Cell*> tested = returnsOfHalf(*cells, true);
  const auto testedBeams = std::ranges::count_if(*cells, &Cell::tested);
  if (static_cast<double>(tested.size()) < kReturned * static_cast<double>(testedBeams)) return {};
  const auto [nearest, farthest] = std::ranges::minmax(tested, {}, &Cell::range);
  if (farthest->range > kDeepest * nearest->range) return {};

  const std::optional<PlaneFit> plane = fitPlane(beams, tested);
  if (!plane) return {};
  FlatPatch patch{.window = window, .plane = plane->plane, .testedPlaneDeviation = std::sqrt(plane->fit.variance())};
  const double distance = 1 / length(plane->plane);
  for (const Cell& cell : *cells) {
    const double cosine = dot(plane->plane, beams.direction[cell.beam]) * distance;
    const double range = rangeOnPlane(beams, cell.beam, plane->plane);
    if (!(cosine > kEdgeOn) || !(range > 0)) return {};
    patch.range += range / kCells;
  }
  const std::uint32_t middle = (*cells)[kCells / 2].beam;
  patch.incidence = dot(plane->plane, beams.direction[middle]) * distance;
  const LinearFit lines = fitLines(beams, tested, plane->plane);
  patch.testedLines = {lines.squares, lines.freedom()};
  if (patch.testedLines.freedom < 1) return {};
  addMeasuredHalf(beams, returnsOfHalf(*cells, false), patch);
  countHoles(beams, *cells, patch.testedPlaneDeviation, patch);
  return patch;
}

}  // namespace

BeamImage::BeamImage(const BeamTable& beams) : columns_(beams.columns), wraps_(beams.fullTurn()) {
  ring_.resize(beams.rings);
  std::iota(ring_.begin(), ring_.end(), 0u);
  std::ranges::stable_sort(ring_,
                           [&](std::uint32_t a, std::uint32_t b) { return beams.elevation[a] > beams.elevation[b]; });
  const double step = beams.columns > 1 ? beams.azimuth(1) - beams.azimuth(0) : 2 * kPi;
  shift_.reserve(ring_.size());
  for (const std::uint32_t ring : ring_) {
    shift_.push_back(static_cast<std::int64_t>(std::llround(beams.azimuthOffset[ring] / step)));
  }
}

std::uint32_t BeamImage::starts(std::uint32_t width) const {
  if (columns_ < width) return 0;
  return wraps_ ? columns_ : columns_ - width + 1;
}

std::optional<std::uint32_t> BeamImage::beam(std::uint32_t row, std::uint32_t column) const {
  std::int64_t ringColumn = static_cast<std::int64_t>(column) - shift_[row];
  const std::int64_t columns = columns_;
  if (wraps_) {
    ringColumn = ((ringColumn % columns) + columns) % columns;
  } else if (ringColumn < 0 || ringColumn >= columns) {
    return {};
  }
  return ring_[row] * columns_ + static_cast<std::uint32_t>(ringColumn);
}

double rangeOnPlane(const BeamTable& beams, std::size_t beam, const PatchPlane& plane) {
  return (1 - dot(plane, beams.originOf(beam))) / dot(plane, beams.direction[beam]);
}

std::vector<double> rangeBandEdges() {
  return {0, 2.5, 5, 7.5, 10, 12.5, 15, 20, 25, 30, 40, 50, 70, 100, 150, 220};
}

std::size_t rangeBandOf(double range) {
  static const std::vector<double> edges = rangeBandEdges();
  const auto next = std::ranges::upper_bound(edges, range);
  return next == edges.begin() ? 0 : static_cast<std::size_t>(next - edges.begin()) - 1;
}

double chiSquareQuantile(double freedom, double standardNormal) {
  const double spread = 2 / (9 * freedom);
  const double root = 1 - spread + standardNormal * std::sqrt(spread);
  return root > 0 ? root * root * root : 0;
}

std::vector<FlatPatch> findFlatPatches(const BeamTable& beams, const std::vector<RecordedScan>& scans) {
  const BeamImage image(beams);
  if (image.rows() < kPatchRings) return {};
  const std::uint32_t rows = image.rows() - kPatchRings + 1;
  const std::uint32_t starts = image.starts(kPatchColumns);
  std::vector<FlatPatch> candidates;
  for (std::uint32_t scan = 0; scan < scans.size(); ++scan) {
    for (std::uint32_t tested = 0; tested < 2; ++tested) {
      std::vector<std::vector<FlatPatch>> perRow(rows);
      parallelForEach(rows, 1, [&](std::size_t row) {
        for (std::uint32_t column = 0; column < starts; column += kColumnStep) {
          const PatchWindow window{scan, static_cast<std::uint32_t>(row), column, tested};
          if (auto patch = measurePatch(beams, image, scans[scan], window)) perRow[row].push_back(*patch);
        }
      });
      for (std::vector<FlatPatch>& row : perRow) {
        std::move(row.begin(), row.end(), std::back_inserter(candidates));
      }
    }
  }
  return chooseFlat(candidates, usualDeviations(candidates), image);
}

}  // namespace scanmill
