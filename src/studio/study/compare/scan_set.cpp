#include "study/compare/scan_set.h"

#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "config/text.h"
#include "dataset/scan_store.h"
#include "evaluate/spread.h"
#include "study/compare/range_grid.h"

namespace scanmill {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kHorizon = -1;  // a ring with a smaller mean elevation (degrees) counts as below the horizon
constexpr std::size_t kLongRun = 10;
constexpr double kGroundReach = 40;   // maximum horizontal distance at which the ground is measured (m)
constexpr double kCell = 0.5;         // edge of a cell in which the relief of the ground is measured (m)
constexpr double kObjectStep = 0.25;  // height difference within a cell (m) above which the cell contains an object
constexpr double kNearPoint = 5;      // points at a smaller range (m) count as near

// Counts and measured values of one scan.
struct ScanCounts {
  std::uint64_t points = 0, near = 0;
  std::uint64_t beams = 0;
  std::uint64_t below = 0, missing = 0, inRuns = 0, single = 0;
  double slope = kNaN, residual = kNaN;  // slope of the ground plane; standard deviation from the plane (m)
  std::vector<double> relief;            // standard deviation of the heights from each cell's plane (m)
  std::uint32_t rows = 0;
  bool knowsRings = false, knowsMisses = false, labelled = false;
  Patches patches;
};

void countBeams(const Scan& scan, const RangeGrid& grid, ScanCounts& counts) {
  for (std::uint32_t row = 0; row < grid.rows; ++row) {
    double elevation = 0;
    std::uint32_t filled = 0;
    for (std::uint32_t c = 0; c < grid.columns; ++c) {
      const std::uint32_t point = grid.point[grid.at(row, c)];
      if (point == RangeGrid::kNone) continue;
      const Vec3d p(scan.position[point]);
      elevation += std::asin(p.z / length(p));
      ++filled;
      counts.near += length(p) < kNearPoint ? 1 : 0;
    }
    counts.beams += grid.columns;
    counts.points += filled;
    if (filled == 0 || degrees(elevation / filled) > kHorizon) continue;
    counts.below += grid.columns;
    // Start at the first return, so that a run of missing beams is not cut at the last column if the grid wraps.
    std::uint32_t first = 0;
    while (grid.point[grid.at(row, first)] == RangeGrid::kNone) ++first;
    std::size_t run = 0;
    const auto end = [&] {
      counts.missing += run;
      if (run > kLongRun) counts.inRuns += run;
      if (run == 1) ++counts.single;
      run = 0;
    };
    for (std::uint32_t k = 0; k < grid.columns; ++k) {
      const std::uint32_t c = (first + k) % grid.columns;
      if (c == 0 && !grid.wraps) end();
      if (grid.point[grid.at(row, c)] == RangeGrid::kNone) {
        ++run;
      } else {
        end();
      }
    }
    end();
  }
}

// Returns a, b and c of the plane z = a x + b y + c that fits the points by least squares.
Eigen::Vector3d levelPlane(const std::vector<Vec3d>& points) {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Vec3d& p : points) {
    const Eigen::Vector3d row(p.x, p.y, 1);
    squares += row * row.transpose();
    right += row * p.z;
  }
  return squares.ldlt().solve(right);
}

double deviationFrom(const Eigen::Vector3d& plane, const std::vector<Vec3d>& points, double freedom) {
  double squares = 0;
  for (const Vec3d& p : points) {
    const double left = p.z - plane[0] * p.x - plane[1] * p.y - plane[2];
    squares += left * left;
  }
  return std::sqrt(squares / (static_cast<double>(points.size()) - freedom));
}

// Measures the ground, which is the level surface below the sensor. Fits a plane to the lowest points, then three times
// a plane to the points within 0.5 m of the previous plane, and last a plane to the points in cells without objects.
void measureGround(const Scan& scan, const RangeGrid& grid, ScanCounts& counts) {
  constexpr double kBelow = 0.3, kOff = 0.5;  // least depth below the sensor, largest distance from a plane (m)
  constexpr std::size_t kFewest = 200, kFewestInCell = 6;
  constexpr double kFewestSpread = 0.05;  // least standard deviation of a cell's points in x and in y (m)
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (grid.point[i] == RangeGrid::kNone) continue;
    const Vec3d p(scan.position[grid.point[i]]);
    if (p.z < -kBelow && std::hypot(p.x, p.y) < kGroundReach) points.push_back(p);
  }
  if (points.size() < kFewest) return;
  // Fits the first plane to the lowest point in each cell of 4 m.
  std::map<std::pair<int, int>, Vec3d> lowest;
  for (const Vec3d& p : points) {
    const std::pair cell{static_cast<int>(std::floor(p.x / 4)), static_cast<int>(std::floor(p.y / 4))};
    const auto [at, fresh] = lowest.emplace(cell, p);
    if (!fresh && p.z < at->second.z) at->second = p;
  }
  std::vector<Vec3d> ground;
  for (const auto& [cell, p] : lowest) ground.push_back(p);
  if (ground.size() < 8) return;
  Eigen::Vector3d plane = levelPlane(ground);
  for (int round = 0; round < 3; ++round) {
    ground.clear();
    for (const Vec3d& p : points) {
      if (std::fabs(p.z - plane[0] * p.x - plane[1] * p.y - plane[2]) < kOff) ground.push_back(p);
    }
    if (ground.size() < kFewest) return;
    plane = levelPlane(ground);
  }
  std::map<std::pair<int, int>, std::vector<Vec3d>> cells;
  for (const Vec3d& p : ground) {
    cells[{static_cast<int>(std::floor(p.x / kCell)), static_cast<int>(std::floor(p.y / kCell))}].push_back(p);
  }
  std::erase_if(cells, [](const auto& cell) {
    const auto [low, high] = std::ranges::minmax_element(cell.second, {}, &Vec3d::z);
    return high->z - low->z > kObjectStep;
  });
  ground.clear();
  for (const auto& [cell, own] : cells) ground.insert(ground.end(), own.begin(), own.end());
  if (ground.size() < kFewest) return;
  plane = levelPlane(ground);
  counts.slope = std::hypot(plane[0], plane[1]);
  counts.residual = deviationFrom(plane, ground, 3);
  for (auto& [cell, own] : cells) {
    if (own.size() < kFewestInCell) continue;
    Vec3d middle;
    for (const Vec3d& p : own) middle += p * (1 / static_cast<double>(own.size()));
    Vec3d spread;
    for (Vec3d& p : own) {
      p = p - middle;
      spread += Vec3d{p.x * p.x, p.y * p.y, 0} * (1 / static_cast<double>(own.size()));
    }
    // Skips cells whose points are nearly on a line, such as those of one ring: they do not determine a plane.
    if (std::sqrt(std::min(spread.x, spread.y)) < kFewestSpread) continue;
    counts.relief.push_back(deviationFrom(levelPlane(own), own, 3));
  }
}

ScanCounts countScan(const Scan& scan, std::uint32_t number, const ScanSetOptions& options) {
  const RangeGrid grid = rangeGrid(scan);
  ScanCounts counts;
  counts.rows = grid.rows;
  counts.knowsRings = grid.knowsRings;
  counts.knowsMisses = grid.knowsMisses;
  counts.labelled = !scan[kLabel].empty();
  countBeams(scan, grid, counts);
  measureGround(scan, grid, counts);
  counts.patches = patchesOf(scan, grid, number, options.patchesPerScan);
  return counts;
}

// Returns by how much `values` differ between rows of the grid: the standard deviation of the rows' medians over flat
// patches, without the part that the medians' standard errors explain. Standard deviations are computed from medians
// too, since a few rows are far off where the ground ends at a wall or a step.
double spreadOverRows(const Patches& patches, const std::vector<float>& values) {
  constexpr std::size_t kFewest = 30, kFewestRows = 4;
  constexpr double kNormal = 1.4826;     // standard deviation / median absolute deviation, for normal distributions
  constexpr double kOfMedian = kPi / 2;  // variance of the median / variance of the mean, for normal distributions
  std::map<std::uint16_t, std::vector<float>> rows;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const bool flat = patches.kind[i] != PatchKind::Rough && patches.kind[i] != PatchKind::Sparse;
    if (flat && !std::isnan(values[i])) rows[patches.row[i]].push_back(values[i]);
  }
  const auto spreadAbout = [](std::vector<float> list, double middle) {
    for (float& v : list) v = static_cast<float>(std::fabs(static_cast<double>(v) - middle));
    return kNormal * quantileOf(std::move(list), 0.5);
  };
  std::vector<float> medians;
  double chance = 0;
  for (const auto& [number, own] : rows) {
    if (own.size() < kFewest) continue;
    const double median = quantileOf(own, 0.5);
    const double spread = spreadAbout(own, median);
    medians.push_back(static_cast<float>(median));
    chance += kOfMedian * spread * spread / static_cast<double>(own.size());
  }
  if (medians.size() < kFewestRows) return kNaN;
  const double spread = spreadAbout(medians, quantileOf(medians, 0.5));
  return std::sqrt(std::max(0.0, spread * spread - chance / static_cast<double>(medians.size())));
}

double& figure(ScanSet& set, std::string_view name) {
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    if (kSetFigures[i].name == name) return set.figures[i];
  }
  throw Error(fmt::format("no figure '{}'", name));
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? kNaN : static_cast<double>(part) / static_cast<double>(whole);
}

void addPatchFigures(ScanSet& set) {
  const Patches& patches = set.patches;
  figure(set, "median_range") = quantileOf(patches.range, 0.5);
  std::uint64_t seen = 0, jumps = 0, edges = 0, mixed = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    constexpr float kFarthest = 35, kApart = 0.1f;
    const float jump = patches.of(Feature::Jump)[i];
    if (patches.range[i] < kFarthest && !std::isnan(jump)) {
      ++seen;
      jumps += jump * patches.range[i] > 1 ? 1 : 0;
    }
    const float between = patches.of(Feature::Mixed)[i];
    edges += std::isnan(between) ? 0 : 1;
    mixed += between >= kApart ? 1 : 0;
  }
  figure(set, "jumps_1m") = share(jumps, seen);
  figure(set, "mixed") = share(mixed, edges);
  figure(set, "intensity_scatter") = quantileOf(patches.of(Feature::IntensityScatter), 0.5);
  figure(set, "ring_offset") = spreadOverRows(patches, patches.ringOffset);
  figure(set, "ring_gain") = spreadOverRows(patches, patches.ringGain);
}

// Combines the counts of all scans, in the order of the scans.
ScanSet addUp(std::string name, std::vector<ScanCounts> all, std::optional<Ontology> ontology) {
  ScanSet set;
  set.name = std::move(name);
  set.scans = static_cast<std::uint32_t>(all.size());
  set.stored = all.size();
  set.labelled = ontology.has_value() && !all.empty();
  set.ontology = std::move(ontology);
  set.figures.fill(kNaN);
  ScanCounts sum;
  std::vector<double> slopes, residuals;
  for (ScanCounts& c : all) {
    sum.points += c.points;
    sum.near += c.near;
    sum.beams += c.beams;
    sum.below += c.below;
    sum.missing += c.missing;
    sum.inRuns += c.inRuns;
    sum.single += c.single;
    sum.relief.insert(sum.relief.end(), c.relief.begin(), c.relief.end());
    if (!std::isnan(c.slope)) {
      slopes.push_back(c.slope);
      residuals.push_back(c.residual);
    }
    set.rows = c.rows;
    set.knowsRings &= c.knowsRings;
    set.knowsMisses &= c.knowsMisses;
    set.labelled &= c.labelled;
    set.patches.append(c.patches);
    c.patches = {};
  }
  set.points = sum.points;
  if (set.knowsMisses) {
    figure(set, "returns") = share(sum.points, sum.beams);
    figure(set, "missing_below") = share(sum.missing, sum.below);
    figure(set, "missing_in_runs") = share(sum.inRuns, sum.missing);
    figure(set, "missing_single") = share(sum.single, sum.missing);
  }
  figure(set, "near") = share(sum.near, sum.points);
  figure(set, "ground_slope") = meanOf(slopes);
  figure(set, "ground_residual") = meanOf(residuals);
  figure(set, "ground_relief") = quantileOf(sum.relief, 0.5);
  figure(set, "ground_relief_90") = quantileOf(sum.relief, 0.9);
  addPatchFigures(set);
  std::vector<float>& intensity = set.patches.of(Feature::Intensity);
  const double median = quantileOf(intensity, 0.5);
  figure(set, "median_intensity") = median;
  for (float& value : intensity) value = median > 0 ? static_cast<float>(value / median) : value;
  return set;
}

}  // namespace

std::size_t comparedBandOf(double range) {
  return static_cast<std::size_t>(std::upper_bound(kRangeBands.begin(), kRangeBands.end(), range) -
                                  kRangeBands.begin());
}

std::string comparedBandName(std::size_t band) {
  if (band == 0) return fmt::format("to {:g} m", kRangeBands[0]);
  if (band == kRangeBands.size()) return fmt::format("beyond {:g} m", kRangeBands.back());
  return fmt::format("{:g} to {:g} m", kRangeBands[band - 1], kRangeBands[band]);
}

ScanSet measureScans(std::string name, const std::vector<Scan>& scans, std::optional<Ontology> ontology,
                     const ScanSetOptions& options) {
  std::vector<ScanCounts> all(scans.size());
  parallelFor(scans.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) all[i] = countScan(scans[i], static_cast<std::uint32_t>(i), options);
  });
  return addUp(std::move(name), std::move(all), std::move(ontology));
}

ScanSet readScanSet(const std::filesystem::path& path, const ScanSetOptions& options, Progress& progress) {
  const ScanStore store(path);
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  const std::string name = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  const std::size_t stored = store.keys().size();
  if (stored == 0) throw InputError({path.string()}, "has no scans");
  const std::vector<std::string> sensors = store.sensors();
  const bool found =
      std::ranges::any_of(sensors, [&](const std::string& own) { return lowerCase(own) == lowerCase(options.sensor); });
  std::string sensor;
  if (sensors.size() > 1 || found) sensor = options.sensor;
  if (sensor.empty()) {
    sensor = store.manifest() != nullptr ? store.manifest()->sensors.front().name : store.scans(0).front().sensor;
  }
  // Samples without a scan of the sensor, which turns more slowly than frames follow each other, are passed over.
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < stored; ++i) {
    const auto own = [&](const StoredScan& s) { return lowerCase(s.sensor) == lowerCase(sensor); };
    if (sensor.empty() || std::ranges::any_of(store.scans(i), own)) held.push_back(i);
  }
  if (held.empty()) static_cast<void>(store.scans(0, sensor));  // throws: no sample has such a sensor
  const std::size_t count = std::min(options.scans, held.size());
  std::vector<ScanCounts> all(count);
  // Process a few scans at a time, to show progress and to limit memory use.
  const auto batch = static_cast<std::size_t>(std::max(1, threadCount()));
  for (std::size_t start = 0; start < count; start += batch) {
    const std::size_t size = std::min(batch, count - start);
    parallelFor(size, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = start + first; k < start + last; ++k) {
        const std::size_t sample = held[k * held.size() / count];
        const Scan scan = store.decode(sample, store.scans(sample, sensor).front());
        all[k] = countScan(scan, static_cast<std::uint32_t>(k), options);
      }
    });
    double points = 0;
    for (std::size_t k = start; k < start + size; ++k) points += static_cast<double>(all[k].points);
    progress.advance(size, points);
    if (options.stop != nullptr && *options.stop) throw Error("stopped: nothing was written");
  }
  std::optional<Ontology> ontology;
  if (store.ontology() != nullptr) ontology = *store.ontology();
  ScanSet set = addUp(name, std::move(all), std::move(ontology));
  set.stored = stored;
  set.foundSensor = found;
  if (set.points == 0) throw InputError({path.string()}, "has only scans without points, which cannot be compared");
  return set;
}

}  // namespace scanmill
