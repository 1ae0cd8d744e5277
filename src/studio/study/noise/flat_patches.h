#pragma once

// Finds flat patches in recorded scans: where the surface is a plane, what differs from it in the ranges is noise.
//
// A patch is a window of neighbouring beams, coloured like a chessboard. The beams of one colour are tested, those of
// the other are measured: the noise of the measured beams has no part in the choice, so that the choice makes it
// neither smaller nor larger. The tested half must fit a plane (least squares of the ranges, along the beams) and
// scatter no more about it than the smoothest tenth of all windows lets expect at its range and incidence. The measured
// half is then fitted once more, by a line of its own for each ring and a bend that all rings share: gently curved
// surfaces, offsets between rings, the beam table's rounding and the vehicle's motion are no noise, and so do not count
// as noise. Each fit's sum of squares is divided by its degrees of freedom.

#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "sensors/beams.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

constexpr std::uint32_t kPatchRings = 5;
constexpr std::uint32_t kPatchColumns = 9;

// The cosine of the incidence, 60 deg, that parts steep views from grazing ones. On grazing views, the surface's own
// roughness and the width of the beam spread the ranges.
constexpr double kSteep = 0.5;

// The beams of a patch.
struct PatchWindow {
  std::uint32_t scan = 0;    // index of the recorded scan
  std::uint32_t row = 0;     // the first of kPatchRings rows, in the order of the elevations
  std::uint32_t column = 0;  // the first of kPatchColumns columns, in the order of the azimuths
  std::uint32_t tested = 0;  // the colour that is tested, 0 or 1
};

// The plane of a patch in the sensor's frame: plane * point = 1 for its points, so that its distance is 1 / |plane|.
using PatchPlane = Vec3d;

struct FlatPatch {
  PatchWindow window;
  PatchPlane plane;      // of the tested half
  double range = 0;      // m, the mean over the window's beams of their ranges to the plane
  double incidence = 0;  // cosine of the angle between the window's middle beam and the plane's normal
  double intensity = 0;  // median of the tested returns; 0 without an intensity

  // Of the tested half.
  double testedSquares = 0;  // m^2, about the lines
  double testedFreedom = 0;
  double testedPlaneDeviation = 0;  // m, root of squares / (n - 3) about the plane

  // Of the measured half.
  double squares = 0;       // m^2, about the lines
  double freedom = 0;       // 0 where there are too few returns
  double planeSquares = 0;  // m^2, about a plane of its own
  double planeFreedom = 0;
  std::vector<double> residuals;  // m, about the lines, each divided by sqrt(1 - leverage): so all have one variance
  std::uint32_t enclosed = 0;     // beams whose neighbours returned from the plane
  std::uint32_t holes = 0;        // those of them that did not return
};

// The beams of a table as an image in which each ring is shifted by its azimuth offset, so that neighbours in the image
// are neighbours in space.
class BeamImage {
 public:
  explicit BeamImage(const BeamTable& beams);

  std::uint32_t rows() const { return static_cast<std::uint32_t>(ring_.size()); }
  std::uint32_t columns() const { return columns_; }
  // How many first columns there are for windows of so many columns.
  std::uint32_t starts(std::uint32_t width) const;
  // The beam of a pixel. Absent where the ring's shift leads out of a field that is no full revolution.
  std::optional<std::uint32_t> beam(std::uint32_t row, std::uint32_t column) const;

 private:
  std::vector<std::uint32_t> ring_;  // per row
  std::vector<std::int64_t> shift_;  // columns, per row
  std::uint32_t columns_ = 0;
  bool wraps_ = false;
};

// The range (m) at which a beam meets a plane; zero or less where it does not meet it.
double rangeOnPlane(const BeamTable& beams, std::size_t beam, const PatchPlane& plane);

// Measures one window, flat or not. Absent where it has too few returns, or where its plane is seen from behind or from
// its edge.
std::optional<FlatPatch> measurePatch(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan,
                                      const PatchWindow& window);

// Finds the flat patches of all scans, in the order of scan, colour and place. Patches of the same colour do not
// overlap.
std::vector<FlatPatch> findFlatPatches(const BeamTable& beams, const std::vector<RecordedScan>& scans);

// The lower edges (m) of the bands of range, ascending; the last band has no end.
std::vector<double> rangeBandEdges();
std::size_t rangeBandOf(double range);

// The standard deviation (m) that most patches share, from the median of their variances, which a few curved or rough
// patches do not move. 0 where there are no patches.
double commonDeviation(const std::vector<const FlatPatch*>& patches);

// The value of chi^2 / freedom that is exceeded as seldom as a standard normal variable exceeds `standardNormal`:
// Wilson and Hilferty, PNAS 17, 1931.
double chiSquareQuantile(double freedom, double standardNormal);

}  // namespace scanmill
