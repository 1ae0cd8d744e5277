#pragma once

// Measures one set of scans, without comparing it with another set.

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/run/progress.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "study/compare/patches.h"

namespace scanmill {

// Figures that describe complete sets of scans.
inline constexpr auto kSetFigures = std::to_array<ComparedFigure>({
    {"returns", "beams that return", "%", 100, "of all beams of the sensor",
     "the scene's openness; detection, dropout, light_paths; the sensor's mount"},
    {"missing_below", "missing below the horizon", "%", 100,
     "beams more than 1 deg below the horizon that have no return",
     "where in runs: windows (light_paths), dark and wet materials (detection), the ego vehicle, holes in the scene; "
     "where single: dropout"},
    {"missing_in_runs", "of these in runs", "%", 100, "in runs of more than 10 neighbours in a ring",
     "materials (windows, dark paint), the ego vehicle, holes in the scene: not dropout, whose beams are single"},
    {"missing_single", "of these single", "%", 100, "between two returns", "dropout (probability), detection (noise)"},
    {"near", "points within 5 m", "%", 100, "of all points", "the sensor's mount, the ego vehicle, narrow streets"},
    {"median_range", "median range", "m", 1, "of all points", "how near the scene's things stand; the sensor's mount"},
    {"ground_slope", "slope of the ground", "%", 100,
     "of the plane through the ground within 40 m (what lies within 0.5 m of the lowest points), mean over scans",
     "the scene's ground"},
    {"ground_residual", "ground about one plane", "mm", 1000,
     "deviation of the ground within 40 m from that plane, mean over scans", "the scene's ground"},
    {"ground_relief", "relief of the ground", "mm", 1000,
     "deviation of heights in cells of 0.5 m about their own plane, median over cells", "effects relief, range_noise"},
    {"ground_relief_90", "relief of rough ground", "mm", 1000, "the same, 90th percentile over cells",
     "effects relief; the materials of the scene's ground"},
    {"jumps_1m", "jumps of more than 1 m", "%", 100, "points within 35 m with such a jump to a neighbour in the ring",
     "the scene: vegetation, thin things"},
    {"mixed", "mixed pixels", "%", 100,
     "edges of more than 1.5 m between two surfaces with a point that lies apart from both, by a tenth or more",
     "effects footprint (rays)"},
    {"median_intensity", "median intensity", "", 1, "of all points, in the unit of the scans",
     "what full scale means: effects intensity (model, gain, output); reflectances in labels/materials.yaml"},
    {"intensity_scatter", "intensity scatter", "%", 100,
     "median difference of a point from the mean of 4 neighbours in its ring; whole numbers of a low median scatter by "
     "their rounding alone",
     "effects speckle, reflectance_variation"},
    {"ring_offset", "fixed offsets of rings", "mm", 1000,
     "deviation over rings of their median offset in range from the rings beside, on flat patches; without what chance "
     "explains",
     "effects ring_bias (range_sigma_m, elevation_sigma_deg)"},
    {"ring_gain", "fixed gains of rings", "%", 100,
     "deviation over rings of their median gain against the rings beside, on flat patches; without what chance "
     "explains",
     "effects ring_bias (gain_sigma)"},
});
inline constexpr std::size_t kSetFigureCount = kSetFigures.size();

// Upper ends of the bands of ranges (m). A last band without upper end follows.
inline constexpr std::array<double, 5> kRangeBands{5, 10, 20, 40, 80};
inline constexpr std::size_t kRangeBandCount = kRangeBands.size() + 1;
std::size_t comparedBandOf(double range);
std::string comparedBandName(std::size_t band);

struct ScanSet {
  std::string name;          // last component of the path
  std::uint32_t scans = 0;   // number of scans that were read
  std::uint64_t stored = 0;  // number of scans in the set
  std::uint64_t points = 0;  // number of points in the scans that were read
  std::uint32_t rows = 0;    // rows of the grid of the scan that was read last; the number of rings if rings are known
  bool foundSensor = false;  // true: the set has a sensor with the requested name
  bool knowsRings = true;    // true: rings are known in all scans
  bool knowsMisses = true;   // true: the beams without a return are known in all scans
  bool labelled = false;     // true: all scans have labels, and their classes are known
  std::optional<Ontology> ontology{};
  // Values in the order of kSetFigures; NaN if the scans do not show the figure.
  std::array<double, kSetFigureCount> figures{};
  Patches patches;  // intensities in them are divided by the set's median
};

struct ScanSetOptions {
  std::string sensor;                  // name of the sensor; empty: the first; ignored if a set has only one sensor
  std::size_t scans = 20;              // maximum number of scans, evenly distributed over the set
  std::size_t patchesPerScan = 20000;  // maximum number of patches per scan
  const std::atomic<bool>* stop = nullptr;
};

// Reads and measures a set of scans: any dataset or folder that ScanStore can open (dataset/scan_store.h). Throws
// InputError; throws Error if `*options.stop` becomes true.
ScanSet readScanSet(const std::filesystem::path& path, const ScanSetOptions& options, Progress& progress);
// Measures scans in memory in the same way as readScanSet().
ScanSet measureScans(std::string name, const std::vector<Scan>& scans, std::optional<Ontology> ontology,
                     const ScanSetOptions& options);

}  // namespace scanmill
