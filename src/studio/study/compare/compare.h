#pragma once

// Compares a real and a simulated set of scans, to find differences that a network trained on one set would notice.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/value.h"
#include "pipeline/run/progress.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "study/compare/patches.h"
#include "study/compare/road_pose.h"

namespace scanmill {

// "Beside" means the pixels to the left and right in the ring; both must be of the class of the middle one if classes
// are compared.
inline constexpr auto kSurfaceFigures = std::to_array<ComparedFigure>({
    {"along_median", "along a ring, median", "mm", 1000, "distance of a range from the mean of the two beside",
     "effects range_noise, quantize and relief; how finely the scene's models are made"},
    {"along_75", "along a ring, 75 %", "mm", 1000, "75th percentile of this distance", "as the median"},
    {"along_90", "along a ring, 90 %", "mm", 1000, "90th percentile of this distance",
     "the scene: leaves, gaps, edges; windows (light_paths)"},
    {"beyond_half", "along a ring, above 0.5 m", "%", 100, "how often this distance is above 0.5 m",
     "the scene: leaves, gaps, edges; windows (light_paths)"},
    {"beyond_two", "along a ring, above 2 m", "%", 100, "how often this distance is above 2 m",
     "the scene: leaves, gaps, edges; windows (light_paths)"},
    {"lost", "lost neighbours", "%", 100, "how often the pixel to the right has no return",
     "effects dropout, detection and light_paths; sky beside the scene's things"},
    {"ring_to_ring", "ring to ring", "m", 1, "median difference of a range from the one above, of the same class",
     "effects ring_bias; how steep the scene's things are"},
});
inline constexpr std::size_t kSurfaceFigureCount = kSurfaceFigures.size();
using SurfaceFigures = std::array<double, kSurfaceFigureCount>;  // NaN: too few pixels

// The lower ends of the bands of ranges (m), and the end of the last.
inline constexpr std::array<double, 5> kSurfaceBands{3, 8, 15, 30, 60};

// The groups of a set's patches. Equal numbers mean the same group in both of the compared sets.
struct Groups {
  std::vector<std::uint16_t> ofPatch;                // group of each patch
  std::map<std::uint16_t, std::uint16_t> ofLabel{};  // group of each class id; empty: groups are shapes
};

// The figures of a set in one group and band of ranges.
struct Surfaces {
  SurfaceFigures figures;
  std::size_t pixels;  // number of pixels whose neighbours in the ring are of the group
};
using SurfacesByGroup = std::map<std::pair<std::uint16_t, std::size_t>, Surfaces>;  // by group and band
// Measures how rough the surfaces of a set are in range images of about 1024 columns a turn. Omits groups and bands
// with too few pixels.
SurfacesByGroup surfacesOf(const Patches& patches, const Groups& groups, bool knowsMisses);

// Figures of both sets in one band of ranges, as shown to users.
struct SurfaceComparison {
  std::string band;
  SurfaceFigures real, simulated;
  std::size_t realPixels;  // pixels of the real set

  // True if a figure can be compared: both sets have it, it is at least kLeastCounted in the real one, and a share is
  // that of several pixels there.
  bool isCounted(std::size_t figure) const;
  // True if the figures of both sets are within the factor kAlike.
  bool isAlike(std::size_t figure) const;
};

// Returns the bands in which both sets have enough pixels of a group.
std::vector<SurfaceComparison> compareSurfaces(const SurfacesByGroup& real, const SurfacesByGroup& simulated,
                                               std::uint16_t group);

// A factor between two figures, and the least figure of the real set (in the unit that users see) that is counted.
inline constexpr double kAlike = 1.5, kLeastCounted = 0.05;

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
    {"median_range", "median range", "m", 1, "of all points", "the scene: how near its things stand", false, true},
    {"ground_residual", "ground about one plane", "mm", 1000,
     "deviation of the ground within 40 m (what lies within 0.5 m of the lowest points) from its plane, mean over "
     "scans",
     "the scene: its ground", false, true},
    {"ground_relief", "relief of the ground", "mm", 1000,
     "deviation of heights in cells of 0.5 m about their own plane, median over cells", "effects relief, range_noise"},
    {"ground_relief_90", "relief of rough ground", "mm", 1000, "the same, 90th percentile over cells",
     "effects relief; the materials of the scene's ground"},
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

struct ScanSet {
  std::string name{};        // last component of the path
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
  // How the sensor stands. compareSets() sets `roadPose` to `roadPoseByShape` unless the road's class is known in both
  // sets.
  RoadPoses roadPose{}, roadPoseByShape{};
  Patches patches{};  // intensities in them are divided by the set's median
};

struct ScanSetOptions {
  std::string sensor;      // name of the sensor; empty: the first; ignored if a set has only one sensor
  std::size_t scans = 20;  // maximum number of scans, evenly distributed over the set
  const std::atomic<bool>* stop = nullptr;
};

// Reads and measures a set of scans: any dataset or folder that ScanStore can open (dataset/scan_store.h). Throws
// InputError if the set cannot be read or has no points, and Error if `*options.stop` becomes true.
ScanSet readScanSet(const std::filesystem::path& path, const ScanSetOptions& options, Progress& progress);
// Measures scans in memory in the same way as readScanSet().
ScanSet measureScans(std::string name, const std::vector<Scan>& scans, std::optional<Ontology> ontology);

// How well a feature of patches separates the two sets. Only patches of the same group and band of ranges are compared,
// so that different places alone cause no differences.
struct Separation {
  std::size_t feature = 0;  // index into kPatchFeatures
  // The mean of |area under the ROC curve - 0.5| over all groups and range bands, weighted by the number of patches in
  // the smaller set. 0: the sets do not differ; 0.5: a single patch is enough to tell the sets apart.
  double strength = 0;
  // The mean area under the ROC curve, weighted as `strength`; above 0.5 if the simulated set has the greater values.
  double area = 0.5;
  std::uint64_t real = 0, simulated = 0;  // numbers of the patches that were compared
  // The median of the feature over these patches; the mean for features that are mostly zero.
  double realValue = 0, simulatedValue = 0;
};

// Patches of one class; if the scans have no labels, patches of one shape.
struct GroupComparison {
  std::string name;
  double realShare = 0, simulatedShare = 0;  // fractions of all patches of the set
  std::vector<Separation> features;          // the strongest first; features that cannot be compared are left out
  std::vector<SurfaceComparison> surfaces;   // how rough its surfaces are, by range; none for patches without a class
};

// A figure of both sets in one band of ranges or incidence angles.
struct BandComparison {
  std::string name;
  double real = 0, simulated = 0;  // NaN if there are too few patches
};

// A figure of both sets, as shown to users.
struct FigurePair {
  double real = 0, simulated = 0;
  std::string_view title, unit;

  double ratio() const { return real / simulated; }
};

// A key of the simulated pipeline and a better value for it.
struct KeyChange {
  std::string key;       // effect and key, such as "speckle.looks", or "sensors.0.mount.pitch_deg"
  FigurePair figure{};   // the figure that suggests the change
  double current = 0;    // present value
  double suggested = 0;  // value with which the figures would be equal if nothing else influenced them
  double deviation = 0;  // not 0: a normal distribution with the mean `suggested` and this deviation is suggested
  bool isEnd = false;    // true: `suggested` ends the key's allowed range, and the figures would still differ

  std::string suggestedText() const;  // returns the suggested value as YAML: "0.07" or "{normal: [0.66, 0.34]}"
};

struct SetComparison {
  ScanSet real, simulated;                  // measurements of both sets; their patches are removed
  std::vector<std::string> warnings;        // reasons why some figures are less meaningful than they seem
  bool byClass = false;                     // true: groups are classes; false: groups are shapes of patches
  Ontology classes;                         // ontology of the groups if byClass is true
  std::vector<std::string> unknownClasses;  // classes of one set that are missing in the ontology of the other set
  std::vector<Separation> features;         // separations over all groups together, the strongest first
  // For each feature, the strength with which it separates the odd from the even scans of the real set: differences
  // that are due to the places alone. NaN if there is only one scan, or too few patches.
  std::array<double, kFeatureCount> withinReal{};
  std::vector<GroupComparison> groups;  // sorted by the larger of realShare and simulatedShare, descending
  std::vector<BandComparison> ranges;   // fractions of each set's patches that are in the bands
  // Median intensities of patches, divided by the median of the set.
  std::vector<BandComparison> intensityByRange, intensityByIncidence;
  std::vector<KeyChange> advice;
  std::vector<std::string> assignments;  // arguments of --set that apply all advice
  std::string unadvised;                 // the reason why there is no advice, as a sentence; empty if there is advice

  // Returns how many figures of surfaces are alike, and how many are counted.
  std::pair<std::size_t, std::size_t> surfacesAlike() const;
  bool sensorsDiffer() const { return real.knowsRings && simulated.knowsRings && real.rows != simulated.rows; }
};

// Compares two sets. Classes of one set are mapped to the other set's classes with the same name or alias, in the
// direction after which the class frequencies agree better; this usually yields the coarser classes. If a set has no
// labels, patches are grouped by shape instead of class.
SetComparison compareSets(ScanSet real, ScanSet simulated);

// Returns the comparison as JSON. `date`: date that the JSON states.
std::string comparisonJson(const SetComparison& comparison, const std::string& date);

// Returns the suggested changes of effects. `effectItems`: effects of the simulated sensor, as returned by
// sensorEffectItems(). Nothing is suggested for effects that the sensor lacks, for keys that are missing or not a
// positive number (0, lists, random values), or for figures that differ by less than a tenth. Errors of rings may
// differ by what another draw for each ring changes: three standard deviations of the ratio.
std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& effectItems);

// Returns an argument of --set that applies changes of effects, such as "effects=[sensor, ring_bias: {gain_sigma:
// 0.07}]". `pipelineItems`: the effects list of the pipeline file.
std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& pipelineItems);

// Returns the suggested changes of the height, pitch and roll of a sensor, and applies them to `mount`, the value of
// its mount in the pipeline file. Suggests a normal distribution for each sequence if a figure varies more over the
// sequences of the real set. Suggests nothing for keys that are not numbers, and no roll unless the simulated vehicle
// is on its wheels. `mountKey`: key of the mount, such as "sensors.0.mount".
std::vector<KeyChange> changeMount(const SetComparison& comparison, const std::string& mountKey, bool isOnWheels,
                                   Value& mount);

// Reads the pipeline of the simulated set, and sets `advice` and `assignments` of the comparison; if there is no
// advice, sets `unadvised` to the reason. Adds a warning if the vehicle does not stand on its wheels, on which advice
// for mounts depends. `simulated`: folder of the set. `sensor`: name of the compared sensor; empty: the first sensor.
// `pipeline`: path of the pipeline file; empty: search for the file.
void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline);

}  // namespace scanmill
