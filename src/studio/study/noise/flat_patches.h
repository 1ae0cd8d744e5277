#pragma once

// Finds flat patches in recorded scans. The deviations of their ranges from a smooth surface are noise.
//
// A patch is a window of neighbouring beams, coloured like a chessboard. Beams of one colour are tested, to choose flat
// patches; beams of the other colour are measured. The noise of the measured beams does not influence the choice, so
// the choice causes no bias. The ranges of the tested half must fit a plane by least squares, and their deviation must
// not be larger than expected from the smoothest tenth of all windows with similar range and incidence. The measured
// half is fitted by a separate line for each ring and a curvature that all rings share, so that curved surfaces,
// offsets between rings, the beam table's rounding and the vehicle's motion do not count as noise. The sum of squares
// of each fit is divided by its degrees of freedom.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

struct RecordedScan {
  std::string name;              // name of the file
  std::vector<double> range;     // distance from each beam's origin to its first return (m); NaN: no return
  std::vector<float> raised;     // elevation of each beam's point above the beam (rad)
  std::vector<float> intensity;  // intensity of each beam; 0 if it has no return; empty if the scan has no intensities
  Pose scanFromSensor;           // pose of the sensor in the frame of the scan's points
  std::size_t returns = 0;
};

// Returns the derivative of a beam's direction by its elevation: a unit vector upwards, perpendicular to the beam.
inline Vec3d upwardsFrom(const Vec3d& direction) {
  const double level = std::max(std::hypot(direction.x, direction.y), 1e-6);
  return {-direction.z * direction.x / level, -direction.z * direction.y / level, level};
}

// Assigns each point of a scan to a beam: in an organised scan by the position in the image, otherwise by the columns
// `ring` and `column` or, without `column`, by ring and azimuth. Only the first return of a beam is used, since later
// returns occur at edges and not on flat surfaces. The sensor's pose in the frame of the points is estimated, since
// recordings often do not state it. Throws InputError if the scan's size is not the sensor's, if rings are unknown, if
// returns are too few, or if points are not on the sensor's beams; the message starts with `name`.
RecordedScan rangesAlong(const Scan& scan, const BeamTable& beams, const std::string& name);

// Returns the step (m) to which the sensor rounds ranges: all ranges differ by multiples of it. 0: no step is found.
double rangeStep(const std::vector<RecordedScan>& scans);

constexpr std::uint32_t kPatchRings = 5;
constexpr std::uint32_t kPatchColumns = 9;

// The incidence angle that separates steep from grazing views (degrees), and its cosine. In grazing views, the ranges
// also vary due to the roughness of the surface and the width of the beam.
constexpr double kMostIncidenceDegrees = 60;
inline const double kSteep = std::cos(radians(kMostIncidenceDegrees));

constexpr double kLeastLevel = 0.9;  // least vertical component of the unit normals of level patches

// The position of a patch in a scan's image of beams.
struct PatchWindow {
  std::uint32_t scan = 0;    // index of the recorded scan
  std::uint32_t row = 0;     // first of kPatchRings rows of BeamImage, which are sorted by elevation
  std::uint32_t column = 0;  // first of kPatchColumns columns of BeamImage, which are sorted by azimuth
  std::uint32_t tested = 0;  // parity of row + column of the tested beams: 0 or 1
};

// The plane of a patch in the sensor's frame: dot(plane, point) = 1. The distance from the origin is 1 / length(plane).
using PatchPlane = Vec3d;

// How well a surface fits the ranges of half of a patch.
struct SurfaceFit {
  double squares = 0;  // sum of squared deviations (m^2)
  double freedom = 0;  // number of degrees of freedom; 0 if there are too few returns

  double variance() const { return squares / freedom; }  // m^2
};

struct FlatPatch {
  PatchWindow window;
  PatchPlane plane;                 // plane fitted to the tested half
  double range = 0;                 // mean range of the plane along the window's beams (m)
  double incidence = 0;             // cosine of the angle between the window's middle beam and the plane's normal
  double testedPlaneDeviation = 0;  // standard deviation of the tested half from the plane (m)
  SurfaceFit testedLines{};         // fit of the rings' lines to the tested half
  SurfaceFit measuredLines{}, measuredPlane{};  // fits of lines and of another plane to the measured half
  std::uint32_t points = 0;    // number of measured returns, except those that determine a coefficient almost alone
  std::uint32_t enclosed = 0;  // number of measured beams with at least three neighbouring returns, all on the plane
  std::uint32_t holes = 0;     // number of enclosed beams that have no return
};

// Arranges the beams of a table as an image, in which each ring is shifted by its azimuth offset. Neighbours in the
// image are then neighbours in direction.
class BeamImage {
 public:
  explicit BeamImage(const BeamTable& beams);

  std::uint32_t rows() const { return static_cast<std::uint32_t>(ring_.size()); }
  std::uint32_t columns() const { return columns_; }
  // Returns the number of columns at which a window of `width` columns can start.
  std::uint32_t starts(std::uint32_t width) const;
  // Returns the index of a pixel's beam. Returns nothing if the ring has no beam there because it is shifted; this
  // happens only if the field of view is less than a full revolution.
  std::optional<std::uint32_t> beam(std::uint32_t row, std::uint32_t column) const;

 private:
  std::vector<std::uint32_t> ring_;  // ring of each row
  std::vector<std::int64_t> shift_;  // number of columns by which each row is shifted
  std::uint32_t columns_ = 0;
  bool wraps_ = false;
};

// Returns the range (m) at which a beam hits a plane; zero or negative if the beam does not hit the plane.
double rangeOnPlane(const BeamTable& beams, std::size_t beam, const PatchPlane& plane);

// Returns the flat patches of all scans, sorted by scan, by the chessboard colour of the tested beams and by position
// in the image. Patches with the same scan and colour do not overlap.
std::vector<FlatPatch> findFlatPatches(const BeamTable& beams, const std::vector<RecordedScan>& scans);

// Returns the lower edges of the bands of range (m), ascending. The last band has no upper edge.
std::vector<double> rangeBandEdges();
std::size_t rangeBandOf(double range);  // returns the index of the band that contains a range (m)

// Returns the quantile of chi^2 / freedom that corresponds to the quantile `standardNormal` of the standard normal
// distribution (Wilson and Hilferty, PNAS 17, 1931).
double chiSquareQuantile(double freedom, double standardNormal);

}  // namespace scanmill
