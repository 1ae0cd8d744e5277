#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "config/text.h"
#include "dataset/names.h"
#include "dataset/scan_store.h"
#include "evaluate/spread.h"
#include "study/compare/compare.h"
#include "study/compare/patches.h"
#include "study/compare/road_pose.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kHorizon = -1;       // a ring with a smaller mean elevation (degrees) counts as below the horizon
constexpr std::size_t kLongRun = 10;  // a run of more missing beams counts in the figure missing_in_runs
constexpr double kGroundReach = 40;   // maximum horizontal distance at which the ground is measured (m)
constexpr double kCell = 0.5;         // edge of a cell in which the relief of the ground is measured (m)
constexpr double kObjectStep = 0.25;  // height difference within a cell (m) above which the cell contains an object
constexpr double kNearPoint = 5;      // points at a smaller range (m) count as near

// Counts and measured values of one scan, or of all scans.
struct ScanMeasures {
  ScanSet set{.labelled = true};         // counts and patches; its figures are not set
  std::uint64_t beams = 0;               // pixels of the grid
  std::uint64_t near = 0;                // beams with a return within kNearPoint
  std::uint64_t below = 0;               // beams of rings below the horizon
  std::uint64_t missing = 0;             // beams in `below` without a return
  std::uint64_t inRuns = 0, single = 0;  // beams in `missing` in runs of more than kLongRun, and in runs of one
  std::vector<double> residuals;         // for each scan with ground: standard deviation from the ground's plane (m)
  std::vector<double> relief;            // standard deviation of the heights from each cell's plane (m)
  PosesBySequence posesByClass, posesByShape;  // how the sensor stands, with the ground found by class and by shape

  void add(ScanMeasures&& more) {
    ++set.scans;
    set.points += more.set.points;
    set.rows = more.set.rows;
    set.knowsRings &= more.set.knowsRings;
    set.knowsMisses &= more.set.knowsMisses;
    set.labelled &= more.set.labelled;
    set.patches.append(more.set.patches);
    more.set.patches = {};  // frees memory
    beams += more.beams;
    near += more.near;
    below += more.below;
    missing += more.missing;
    inRuns += more.inRuns;
    single += more.single;
    const auto append = [](auto& list, const auto& added) { list.insert(list.end(), added.begin(), added.end()); };
    append(residuals, more.residuals);
    append(relief, more.relief);
    for (const auto& [sequence, poses] : more.posesByClass) append(posesByClass[sequence], poses);
    for (const auto& [sequence, poses] : more.posesByShape) append(posesByShape[sequence], poses);
  }
};

// Counts the beams without a return in a row. The row must be below the horizon and have at least one return.
void countMissing(const RangeGrid& grid, std::uint32_t row, ScanMeasures& counts) {
  counts.below += grid.columns;
  const auto isMissing = [&](std::uint32_t column) { return grid.point[grid.at(row, column)] == RangeGrid::kNone; };
  // Start at the first return, so that a run of missing beams is not cut at the last column if the grid wraps.
  std::uint32_t first = 0;
  while (isMissing(first)) ++first;
  std::vector<std::size_t> runs;  // lengths of the runs of neighbouring beams without a return
  bool isInRun = false;
  for (std::uint32_t k = 0; k < grid.columns; ++k) {
    const std::uint32_t column = (first + k) % grid.columns;
    const bool continuesRun = isInRun && (column > 0 || grid.wraps);
    isInRun = isMissing(column);
    if (!isInRun) continue;
    if (!continuesRun) runs.push_back(0);
    ++runs.back();
  }
  for (const std::size_t length : runs) {
    counts.missing += length;
    if (length > kLongRun) counts.inRuns += length;
    if (length == 1) ++counts.single;
  }
}

// Counts the beams and returns of all rows, and the missing beams of rows below the horizon.
void countBeams(const Scan& scan, const RangeGrid& grid, ScanMeasures& counts) {
  for (std::uint32_t row = 0; row < grid.rows; ++row) {
    double elevations = 0;  // sum over the row's points (rad)
    std::uint32_t filled = 0;
    for (std::uint32_t c = 0; c < grid.columns; ++c) {
      const std::uint32_t point = grid.point[grid.at(row, c)];
      if (point == RangeGrid::kNone) continue;
      const Vec3d p(scan.position[point]);
      elevations += std::asin(p.z / length(p));
      ++filled;
      counts.near += length(p) < kNearPoint ? 1 : 0;
    }
    counts.beams += grid.columns;
    counts.set.points += filled;
    if (filled > 0 && degrees(elevations / filled) <= kHorizon) countMissing(grid, row, counts);
  }
}

// Adds the residual and the relief of the scan's ground, if enough ground is found.
void measureGround(const Scan& scan, const RangeGrid& grid, ScanMeasures& counts) {
  constexpr std::size_t kFewestPoints = 200, kFewestInCell = 6;
  constexpr double kLeastWidth = 0.05;  // m; no plane can be fitted to the points of one ring
  std::vector<Vec3d> points;
  for (const std::uint32_t point : grid.point) {
    if (point == RangeGrid::kNone) continue;
    const Vec3d p(scan.position[point]);
    if (std::hypot(p.x, p.y) < kGroundReach) points.push_back(p);
  }
  std::map<std::pair<double, double>, std::vector<Vec3d>> cells;  // ground by square cell, as seen from above
  for (const Vec3d& p : groundAmong(std::move(points))) {
    cells[{std::floor(p.x / kCell), std::floor(p.y / kCell)}].push_back(p);
  }
  std::erase_if(cells, [](const auto& cell) {
    const auto [low, high] = std::ranges::minmax_element(cell.second, {}, &Vec3d::z);
    return high->z - low->z > kObjectStep;
  });
  std::vector<Vec3d> ground;
  for (const auto& [cell, inCell] : cells) ground.insert(ground.end(), inCell.begin(), inCell.end());
  if (ground.size() < kFewestPoints) return;
  counts.residuals.push_back(planeOf(ground).thickness);
  for (const auto& [cell, inCell] : cells) {
    if (inCell.size() < kFewestInCell) continue;
    const Plane plane = planeOf(inCell);
    const auto count = static_cast<double>(inCell.size());
    // The plane has three coefficients, which make the points seem nearer to it.
    if (plane.width >= kLeastWidth) counts.relief.push_back(plane.thickness * std::sqrt(count / (count - 3)));
  }
}

// Returns the measures of a scan. `index`: index of the scan in its set. `ontology`: classes of the labels; null:
// unknown. `sequence`: name of the scan's sequence. `heading`: see roadPoseOf().
ScanMeasures measureScan(const Scan& scan, std::size_t index, const Ontology* ontology,
                         const std::string& sequence = "", double heading = 0) {
  const RangeGrid grid = rangeGrid(scan);
  ScanMeasures counts;
  counts.set = {.rows = grid.rows,
                .knowsRings = grid.knowsRings,
                .knowsMisses = grid.knowsMisses,
                .labelled = !scan[kLabel].empty()};
  countBeams(scan, grid, counts);
  measureGround(scan, grid, counts);
  if (ontology != nullptr) counts.posesByClass[sequence] = {roadPoseOf(scan, ontology, heading)};
  counts.posesByShape[sequence] = {roadPoseOf(scan, nullptr, heading)};
  counts.set.patches = patchesOf(scan, grid, static_cast<std::uint32_t>(index));
  return counts;
}

// Returns how much a patch value differs between the rows of the grid: the standard deviation of the rows' medians on
// flat patches, without the part that the medians' standard errors explain; NaN if too few rows have enough patches.
// Deviations are computed as median absolute deviations, since a few rows are far off where the ground ends at a wall.
// `values`: one per patch, NaN if not measured.
double spreadOverRows(const Patches& patches, const std::vector<float>& values) {
  constexpr std::size_t kFewestInRow = 30, kFewestRows = 4;
  // Ratios for normal distributions: standard deviation / median absolute deviation, and variance of the median /
  // variance of the mean.
  constexpr double kDeviationPerMad = 1.4826, kMedianVariance = kPi / 2;
  std::map<std::uint16_t, std::vector<float>> rows;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const bool flat = patches.kind[i] != PatchKind::Rough && patches.kind[i] != PatchKind::Sparse;
    if (flat && !std::isnan(values[i])) rows[patches.row[i]].push_back(values[i]);
  }
  const auto deviationFrom = [](double median, std::vector<float> list) {
    for (float& v : list) v = static_cast<float>(std::fabs(static_cast<double>(v) - median));
    return kDeviationPerMad * quantileOf(std::move(list), 0.5);
  };
  std::vector<float> medians;
  double errorVariances = 0;  // sum of the squared standard errors of the medians
  for (const auto& [row, rowValues] : rows) {
    if (rowValues.size() < kFewestInRow) continue;
    const double median = quantileOf(rowValues, 0.5);
    const double deviation = deviationFrom(median, rowValues);
    medians.push_back(static_cast<float>(median));
    errorVariances += kMedianVariance * deviation * deviation / static_cast<double>(rowValues.size());
  }
  if (medians.size() < kFewestRows) return kNaN;
  const double deviation = deviationFrom(quantileOf(medians, 0.5), medians);
  return std::sqrt(std::max(0.0, deviation * deviation - errorVariances / static_cast<double>(medians.size())));
}

double& figureNamed(ScanSet& set, std::string_view name) {
  const auto found = std::ranges::find(kSetFigures, name, &ComparedFigure::name);
  if (found == kSetFigures.end()) throw Error("no figure '{}'", name);
  return set.figures[static_cast<std::size_t>(found - kSetFigures.begin())];
}

// Sets the figures that follow from the set's patches, as kSetFigures explains them.
void addPatchFigures(ScanSet& set) {
  constexpr float kMixed = 0.1f;  // least distance of a mixed pixel from both surfaces, as a fraction of the edge
  const Patches& patches = set.patches;
  figureNamed(set, "median_range") = quantileOf(patches.range, 0.5);
  std::uint64_t edges = 0, mixed = 0;
  for (const float fromSurface : patches.of(Feature::Mixed)) {
    edges += std::isnan(fromSurface) ? 0 : 1;
    mixed += fromSurface >= kMixed ? 1 : 0;
  }
  figureNamed(set, "mixed") = shareOf(mixed, edges, kNaN);
  figureNamed(set, "intensity_scatter") = quantileOf(patches.of(Feature::IntensityScatter), 0.5);
  figureNamed(set, "ring_offset") = spreadOverRows(patches, patches.ringOffset);
  figureNamed(set, "ring_gain") = spreadOverRows(patches, patches.ringGain);
}

// Combines the measures of all scans, in their order. Divides the intensities of patches by the set's median.
ScanSet combine(std::string name, std::vector<ScanMeasures> scanMeasures, std::optional<Ontology> ontology) {
  ScanMeasures sum;
  for (ScanMeasures& scan : scanMeasures) sum.add(std::move(scan));
  ScanSet set = std::move(sum.set);
  set.name = std::move(name);
  set.stored = set.scans;
  set.labelled = set.labelled && ontology.has_value() && set.scans > 0;
  set.ontology = std::move(ontology);
  set.roadPoseByShape = spreadsOf(sum.posesByShape);
  set.roadPose = set.labelled ? spreadsOf(sum.posesByClass) : set.roadPoseByShape;
  set.figures.fill(kNaN);
  if (set.knowsMisses) {
    figureNamed(set, "returns") = shareOf(set.points, sum.beams, kNaN);
    figureNamed(set, "missing_below") = shareOf(sum.missing, sum.below, kNaN);
    figureNamed(set, "missing_in_runs") = shareOf(sum.inRuns, sum.missing, kNaN);
    figureNamed(set, "missing_single") = shareOf(sum.single, sum.missing, kNaN);
  }
  figureNamed(set, "near") = shareOf(sum.near, set.points, kNaN);
  figureNamed(set, "ground_residual") = meanOf(sum.residuals);
  figureNamed(set, "ground_relief") = quantileOf(sum.relief, 0.5);
  figureNamed(set, "ground_relief_90") = quantileOf(sum.relief, 0.9);
  addPatchFigures(set);
  std::vector<float>& intensity = set.patches.of(Feature::Intensity);
  const double median = quantileOf(intensity, 0.5);
  figureNamed(set, "median_intensity") = median;
  for (float& value : intensity) value = median > 0 ? static_cast<float>(value / median) : value;
  return set;
}

// Returns the name of the sensor to measure: `requested`, or the first sensor if `requested` is empty. A set's only
// sensor is measured whatever its name. `isFound`: true if the set has the requested sensor.
std::string sensorToMeasure(const ScanStore& store, const std::string& requested, bool isFound) {
  if (!requested.empty() && (store.sensors().size() > 1 || isFound)) return requested;
  return store.manifest() != nullptr ? store.manifest()->sensors.front().name : store.scans(0).front().sensor;
}

// Returns the indices of the samples with a scan of the sensor; some samples have none if a revolution takes longer
// than a frame. An empty name means any sensor. Throws InputError if no sample has such a scan.
std::vector<std::size_t> samplesWith(const ScanStore& store, const std::string& sensor) {
  std::vector<std::size_t> samples;
  const auto isOfSensor = [&](const StoredScan& s) { return lowerCase(s.sensor) == lowerCase(sensor); };
  for (std::size_t i = 0; i < store.keys().size(); ++i) {
    if (sensor.empty() || std::ranges::any_of(store.scans(i), isOfSensor)) samples.push_back(i);
  }
  if (samples.empty()) static_cast<void>(store.scans(0, sensor));  // throws, since no sample has the sensor
  return samples;
}

}  // namespace

ScanSet measureScans(std::string name, const std::vector<Scan>& scans, std::optional<Ontology> ontology) {
  std::vector<ScanMeasures> scanMeasures(scans.size());
  parallelForEach(scans.size(), 1,
                  [&](std::size_t i) { scanMeasures[i] = measureScan(scans[i], i, ontology ? &*ontology : nullptr); });
  return combine(std::move(name), std::move(scanMeasures), std::move(ontology));
}

ScanSet readScanSet(const std::filesystem::path& path, const ScanSetOptions& options, Progress& progress) {
  const ScanStore store(path);
  if (store.keys().empty()) throw InputError({path.string()}, "has no scans");
  const auto isRequested = [&](const auto& name) { return lowerCase(name) == lowerCase(options.sensor); };
  const bool foundSensor = std::ranges::any_of(store.sensors(), isRequested);
  const std::string sensor = sensorToMeasure(store, options.sensor, foundSensor);
  const std::vector<std::size_t> samples = samplesWith(store, sensor);
  const std::size_t count = std::min(options.scans, samples.size());
  std::vector<ScanMeasures> scanMeasures(count);
  // Process a few scans at a time, to show progress and to limit memory use.
  const auto batch = static_cast<std::size_t>(std::max(1, threadCount()));
  for (std::size_t start = 0; start < count; start += batch) {
    const std::size_t size = std::min(batch, count - start);
    parallelForEach(size, 1, [&](std::size_t i) {
      const std::size_t sample = samples[(start + i) * samples.size() / count];
      const Scan scan = store.decode(sample, store.scans(sample, sensor).front());
      scanMeasures[start + i] =
          measureScan(scan, start + i, store.ontology(), partsOfKey(store.keys()[sample]).sequence, store.heading());
    });
    double points = 0;
    for (std::size_t k = start; k < start + size; ++k) points += static_cast<double>(scanMeasures[k].set.points);
    progress.advance(size, points);
    if (options.stop != nullptr && *options.stop) throw Error("stopped: nothing was written");
  }
  std::optional<Ontology> ontology;
  if (store.ontology() != nullptr) ontology = *store.ontology();
  ScanSet set = combine(lastName(path), std::move(scanMeasures), std::move(ontology));
  set.stored = store.keys().size();
  set.foundSensor = foundSensor;
  if (set.points == 0) throw InputError({path.string()}, "has only scans without points, which cannot be compared");
  return set;
}

}  // namespace scanmill
