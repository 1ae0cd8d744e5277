#pragma once

// Finds flat patches in recorded scans: on a plane, deviations of the ranges from it are noise.
//
// A patch is a window of neighbouring beams, coloured like a chessboard. The beams of one colour are tested and the
// beams of the other colour are measured: since the noise of the measured beams does not influence the choice, the
// choice does not bias it. The tested half must fit a plane (least squares of the ranges, along the beams) and scatter
// no more about it than expected from the smoothest tenth of all windows at its range and incidence. The measured half
// is then fitted again, by a separate line for each ring and a curvature that all rings share, because gently curved
// surfaces, offsets between rings, the beam table's rounding and the vehicle's motion must not count as noise. Each
// fit's sum of squares is divided by its degrees of freedom.

#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "sensors/beams.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

constexpr std::uint32_t kPatchRings = 5;
constexpr std::uint32_t kPatchColumns = 9;

// The cosine of the incidence, 60 deg, that separates steep views from grazing views. On grazing views, the surface's
// own roughness and the width of the beam spread the ranges.
constexpr double kSteep = 0.5;

// The beams of a patch.
struct PatchWindow {
  std::uint32_t scan = 0;    // index of the recorded scan
  std::uint32_t row = 0;     // the first of kPatchRings rows, in the order of the elevations
  std::uint32_t column = 0;  // the first of kPatchColumns columns, in the order of the azimuths
  std::uint32_t tested = 0;  // colour of the tested beams, 0 or 1
};

// The plane of a patch in the sensor's frame: plane * point = 1 for its points; its distance from the origin is 1 /
// |plane|.
using PatchPlane = Vec3d;

struct FlatPatch {
  PatchWindow window;
  PatchPlane plane;      // fitted to the tested half
  double range = 0;      // m, mean range of the window's beams to the plane
  double incidence = 0;  // cosine of the angle between the window's middle beam and the plane's normal
  double intensity = 0;  // median of the tested returns; 0 if the scan has no intensities

  // Figures of the tested half:
  double testedSquares = 0;  // m^2, about the lines
  double testedFreedom = 0;
  double testedPlaneDeviation = 0;  // m, root of squares / (n - 3) about the plane

  // Figures of the measured half:
  double squares = 0;       // m^2, about the lines
  double freedom = 0;       // 0 if there are too few returns
  double planeSquares = 0;  // m^2, about a plane fitted to this half
  double planeFreedom = 0;
  std::vector<double> residuals;  // m, about the lines, divided by sqrt(1 - leverage) for equal variances
  std::uint32_t enclosed = 0;     // beams whose neighbours returned from the plane
  std::uint32_t holes = 0;        // enclosed beams without a return
};

// The beams of a table as an image in which each ring is shifted by its azimuth offset, so that neighbours in the image
// are neighbours in space.
class BeamImage {
 public:
  explicit BeamImage(const BeamTable& beams);

  std::uint32_t rows() const { return static_cast<std::uint32_t>(ring_.size()); }
  std::uint32_t columns() const { return columns_; }
  // Returns the number of possible first columns for windows of this width (columns).
  std::uint32_t starts(std::uint32_t width) const;
  // Returns the beam of a pixel. Absent if the ring's shift leads out of a field of view below a full revolution.
  std::optional<std::uint32_t> beam(std::uint32_t row, std::uint32_t column) const;

 private:
  std::vector<std::uint32_t> ring_;  // per row
  std::vector<std::int64_t> shift_;  // columns, per row
  std::uint32_t columns_ = 0;
  bool wraps_ = false;
};

// Returns the range (m) at which a beam hits a plane; zero or less if it does not hit.
double rangeOnPlane(const BeamTable& beams, std::size_t beam, const PatchPlane& plane);

// Measures one window, flat or not. Absent if the window has too few returns, or if its plane is seen from behind or
// edge-on.
std::optional<FlatPatch> measurePatch(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan,
                                      const PatchWindow& window);

// Finds the flat patches of all scans, in the order of scan, colour and position in the image. Patches of the same
// colour do not overlap.
std::vector<FlatPatch> findFlatPatches(const BeamTable& beams, const std::vector<RecordedScan>& scans);

// Returns the lower edges (m) of the bands of range, ascending; the last band has no upper edge.
std::vector<double> rangeBandEdges();
std::size_t rangeBandOf(double range);

// Returns the standard deviation (m) that most patches share. It comes from the median of their variances, which is
// robust against a few curved or rough patches. 0 if there are no patches.
double commonDeviation(const std::vector<const FlatPatch*>& patches);

// Returns the value that chi^2 / freedom exceeds as seldom as a standard normal variable exceeds `standardNormal`:
// Wilson and Hilferty, PNAS 17, 1931.
double chiSquareQuantile(double freedom, double standardNormal);

}  // namespace scanmill
