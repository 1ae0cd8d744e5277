#pragma once

// Measures features of patches of a scan. A patch is a window of neighbouring returns around a point, about as large as
// the receptive field of the first layers of a network.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// A scan as an image. Rows are rings, or steps of elevation, from top to bottom; columns are successive azimuth steps.
// Rows are shifted such that a column has the same azimuth in all rows, to within half a step; this matters for lasers
// side by side, whose columns differ in azimuth. If a beam has several returns, the pixel has the nearest.
struct RangeGrid {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t rows = 0, columns = 0;
  bool wraps = false;        // true: the last column is a neighbour of the first
  bool knowsRings = false;   // true: rows are the sensor's rings; false: rows are steps of elevation
  bool knowsMisses = false;  // true: an empty pixel is a beam without a return; false: it may be a gap between beams
  std::vector<std::uint32_t> point;   // index in the scan for each pixel (row * columns + column); kNone: empty
  std::vector<float> range;           // distance from the origin of the points' frame for each pixel (m); NaN: empty
  std::vector<std::uint8_t> returns;  // number of returns of each pixel's beam

  std::size_t size() const { return point.size(); }
  std::size_t at(std::uint32_t row, std::uint32_t column) const { return std::size_t{row} * columns + column; }
  // Returns the index of the pixel that is `steps` columns to the right in the same row (to the left if negative);
  // kNone beyond the edge of a grid that does not wrap.
  std::uint32_t beside(std::uint32_t row, std::uint32_t column, int steps) const;
};

// Builds the grid of a scan. If the scan assigns its points to beams, the pixels are these beams. If the scan has only
// rings, the column width is the median azimuth step between consecutive points, and the points of a ring are placed in
// the order of their azimuths. If the scan has neither, the grid has 1024 columns and 64 rows, which divide the
// elevations of the middle 99 % of the points evenly. A scan without points gives an empty grid.
RangeGrid rangeGrid(const Scan& scan);

constexpr int kPatchReach = 4;     // number of columns on each side of a patch's middle
constexpr int kPatchRowReach = 2;  // number of rows above and below a patch's middle
constexpr double kJump = 0.3;      // range difference (m) between neighbours above which there is an edge
constexpr double kEdge = 1.5;      // least range difference (m) of an edge at which mixed pixels are searched for

// A figure by which sets of scans are compared.
struct ComparedFigure {
  std::string_view name;   // name in JSON
  std::string_view title;  // name for users
  std::string_view unit;   // unit of shown values; a shown value is the stored value times `factor`
  double factor;
  std::string_view meaning;   // explanation, as a phrase
  std::string_view keys;      // what influences the figure: keys of a pipeline, properties of the scene
  bool isMostlyZero = false;  // true: users see the feature's mean over patches; false: its median
  bool isOfScene = false;     // true: no setting of effects or sensors moves the figure, only another scene
  // Words for a simulated set whose value is greater or less, and the smallest difference that they name.
  std::string_view more{}, less{};
  double leastDifference = 0;
};

struct Plane {
  Vec3d middle, normal;  // centroid (m); unit normal, upwards
  double thickness = 0;  // standard deviation along the normal (m)
  double width = 0;      // the smaller of the two other standard deviations (m)

  double distanceOf(const Vec3d& p) const { return dot(normal, p - middle); }  // m, positive above the plane
};

// Fits a plane to at least three points by principal components.
Plane planeOf(std::span<const Vec3d> points);

enum class Feature : std::size_t {
  RangeScatter,
  Thickness,
  RelativeThickness,
  Steepness,
  RingOffset,
  Intensity,
  IntensityScatter,
  RingGain,
  Missing,
  SingleMissing,
  Mixed,
  Returns,
};

inline constexpr auto kPatchFeatures = std::to_array<ComparedFigure>({
    {"range_scatter", "range scatter", "mm", 1000,
     "deviation of the ranges of 7 neighbours in a ring from a parabola, where none jumps",
     "effects range_noise (sigma_m, table), quantize; relief on rough surfaces"},
    {"thickness", "thickness of surfaces", "mm", 1000,
     "deviation of the points of 5 x 9 beams from their plane, those nearby in range alone",
     "effects relief and range_noise; how finely the scene's models are made"},
    {"relative_thickness", "relative thickness", "", 1,
     "thickness over the lesser width of the same points: 0 a plane, 1 a ball",
     "effects relief and range_noise; leaves and twigs of the scene's vegetation"},
    {"steepness", "steepness", "deg", 1, "angle between the patch's normal and the vertical: 0 level, 90 a wall",
     "the scene: slopes, what stands beside the road", false, true},
    {"ring_offset", "offset from the rings beside", "mm", 1000,
     "distance of 5 neighbours' mean from the plane of the rings above and below",
     "effects ring_bias (range_sigma_m, elevation_sigma_deg); relief"},
    {"intensity", "intensity", "", 1, "intensity in units of the set's median",
     "reflectances in labels/materials.yaml, effects intensity and reflectance_variation"},
    {"intensity_scatter", "intensity scatter", "%", 100,
     "difference of the intensity from the mean of the 4 neighbours in its ring, in parts of that; whole numbers of a "
     "low "
     "median scatter by their rounding alone",
     "effects speckle (looks) and reflectance_variation"},
    {"ring_gain", "gain against the rings beside", "%", 100,
     "logarithm of the mean intensity of 5 neighbours over that of the rings above and below",
     "effects ring_bias (gain_sigma)"},
    {"missing", "missing beams", "%", 100, "share of the 5 x 9 beams without a return",
     "windows (light_paths), dark and wet materials (detection), the ego vehicle, gaps in the scene; single ones: "
     "dropout",
     true},
    {"single_missing", "single missing beams", "%", 100,
     "share of the 7 beams around in the ring that are missing between two returns at one range",
     "effects dropout (probability) and detection (noise)", true},
    {"mixed", "mixed pixels", "", 1,
     "where a point lies between two surfaces that are 1.5 m or more apart: 0 at one of them, 0.5 in the middle",
     "effects footprint (rays)", true},
    {"returns", "returns of a beam", "", 1, "how many returns the beam has",
     "effects detection (returns), footprint, light_paths and weather", true},
});
inline constexpr std::size_t kFeatureCount = kPatchFeatures.size();

// The shape of a patch. If scans have no labels, patches are grouped by shape.
enum class PatchKind : std::uint8_t { Level, Upright, Slanted, Rough, Sparse };
inline constexpr std::array<std::string_view, 5> kPatchKinds{"level", "upright", "slanted", "rough", "sparse"};

// The pixels beside a patch's middle in a range image of about 1024 columns a turn, as networks see scans. A pixel has
// the nearest return of its beams.
struct PixelNeighbours {
  enum : std::size_t { kLeft, kRight, kAbove, kCount };
  bool isPixel = false;                       // true: the patch's middle is the nearest return of its own pixel
  std::array<float, kCount> range{};          // range of each neighbour (m); NaN: no return
  std::array<std::uint16_t, kCount> label{};  // class id of each neighbour; 0 if there is none
};

// Features of patches; each vector has one entry per patch.
struct Patches {
  // Values of each Feature in the order of the enumeration; NaN if the feature cannot be measured on the patch.
  std::array<std::vector<float>, kFeatureCount> value;
  std::vector<float> range;      // range of the middle point (m)
  std::vector<float> incidence;  // angle between beam and plane normal (rad); NaN if the patch has no plane
  // Offset along the beam (m) of the middle ring's points from the plane of the rings above and below; positive if they
  // are behind this plane; NaN if not measured, as at grazing incidence.
  std::vector<float> ringOffset;
  std::vector<float> ringGain;       // like Feature::RingGain, but with sign
  std::vector<std::uint16_t> row;    // row of the middle point in the grid
  std::vector<std::uint16_t> label;  // class id of the middle point; 0 if the scan has no labels
  std::vector<PatchKind> kind;
  std::vector<PixelNeighbours> beside;
  std::vector<std::uint32_t> scan;  // index of the scan in its set

  std::size_t size() const { return range.size(); }
  const std::vector<float>& of(Feature feature) const { return value[static_cast<std::size_t>(feature)]; }
  std::vector<float>& of(Feature feature) { return value[static_cast<std::size_t>(feature)]; }
  void append(const Patches& more);
};

// Returns the patches around at most 20,000 points, which are evenly distributed over the scan. The same scan always
// gives the same patches. `scanIndex`: index of the scan in its set.
Patches patchesOf(const Scan& scan, const RangeGrid& grid, std::uint32_t scanIndex);

}  // namespace scanmill
