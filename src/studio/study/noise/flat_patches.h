#pragma once

// Flat patches of recorded scans: where the surface is a plane, what is left of the ranges is noise.
//
// A patch is a window of neighbouring beams, coloured like a chessboard. One colour is tested, the other is measured:
// the noise of the beams that are measured has no part in the choice, so the choice does not make it smaller or larger.
// The tested half must fit a plane (least squares of the ranges, along the beams) and scatter no more about it than the
// smoothest tenth of all windows lets expect, at its range and as steeply seen. The measured half is then fitted once
// more, by a line of its own for each ring and a bend that all share: so gently curved surfaces, offsets between rings,
// the beam table's rounding and the vehicle's motion, all of which are no noise, do not count as such. Each fit's sum
// of squares is divided by its degrees of freedom.

#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "sensors/beams.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

constexpr std::uint32_t kPatchRings = 5;
constexpr std::uint32_t kPatchColumns = 9;

// Cosine of the incidence that parts steep views from grazing ones: 60 deg. On grazing ones, the surface's own
// roughness and the width of the beam spread the ranges.
constexpr double kSteep = 0.5;

// Which beams of which scan, and which colour is tested.
struct PatchWindow {
  std::uint32_t scan = 0;
  std::uint32_t row = 0;     // first of kPatchRings, in the order of the elevations
  std::uint32_t column = 0;  // first of kPatchColumns, in the order of the azimuths
  std::uint32_t tested = 0;  // 0 or 1
};

// The plane of a patch: plane * point = 1 for its points (sensor frame), so its distance is 1 / |plane|.
using PatchPlane = Vec3d;

struct FlatPatch {
  PatchWindow window;
  PatchPlane plane;      // of the tested half
  double range = 0;      // m, mean over the window's beams, on the plane
  double incidence = 0;  // cosine of the angle between the window's middle beam and the plane's normal
  double intensity = 0;  // median of the tested returns; 0 without an intensity

  // The tested half.
  double testedSquares = 0;  // m^2, about the lines
  double testedFreedom = 0;
  double testedPlaneDeviation = 0;  // m, root of squares / (n - 3) about the plane

  // The measured half.
  double squares = 0;       // m^2, about the lines
  double freedom = 0;       // 0: too few returns
  double planeSquares = 0;  // m^2, about a plane of its own
  double planeFreedom = 0;
  std::vector<double> residuals;  // m, about the lines, each divided by sqrt(1 - leverage): all of one variance
  std::uint32_t enclosed = 0;     // beams whose neighbours returned from the plane
  std::uint32_t holes = 0;        // of these, without a return

  // Both halves.
  double density = 0;          // returns per m^2 of the plane
  double expectedDensity = 0;  // by the beam table, if every beam returned
};

// The beams of a table as an image without the sensor's stagger: neighbours in the image are neighbours in space.
class BeamImage {
 public:
  explicit BeamImage(const BeamTable& beams);

  std::uint32_t rows() const { return static_cast<std::uint32_t>(ring_.size()); }
  std::uint32_t columns() const { return columns_; }
  // First columns that windows of so many columns may have.
  std::uint32_t starts(std::uint32_t width) const;
  // Nothing where the ring's stagger leads out of a field that is no full turn.
  std::optional<std::uint32_t> beam(std::uint32_t row, std::uint32_t column) const;

 private:
  std::vector<std::uint32_t> ring_;  // per row
  std::vector<std::int64_t> shift_;  // columns, per row
  std::uint32_t columns_ = 0;
  bool wraps_ = false;
};

// The range at which a beam meets a plane (m); not positive where it does not.
double rangeOnPlane(const BeamTable& beams, std::size_t beam, const PatchPlane& plane);

// Measures one window, flat or not. Nothing where it has too few returns or its plane is seen from behind or from its
// edge.
std::optional<FlatPatch> measurePatch(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan,
                                      const PatchWindow& window);

// Flat patches of all scans that do not overlap but with those of the other colour. In order of scan, colour and place.
std::vector<FlatPatch> findFlatPatches(const BeamTable& beams, const std::vector<RecordedScan>& scans);

// By ranges, for what depends on them: edges of the bands (m), ascending; the last has no end.
std::vector<double> rangeBandEdges();
std::size_t rangeBandOf(double range);

// Standard deviation (m) that most patches share: from the median of their variances, which few curved or rough ones
// among them do not move. 0 where there are none.
double commonDeviation(const std::vector<const FlatPatch*>& patches);

// Below it lies such a share of the values of chi^2 / freedom: Wilson and Hilferty, PNAS 17, 1931.
double chiSquareQuantile(double freedom, double standardNormal);

}  // namespace scanmill
