#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "evaluate/spread.h"
#include "study/noise/fit_noise.h"

namespace scanmill {

namespace {

constexpr std::size_t kFewestBeams = 20;  // a patch with fewer returns is not used
constexpr double kRidge = 0.1;            // weight of the ridge, see RingSystem; chosen by eye
constexpr double kOutlier = 5;            // ranges farther from the plane than this multiple of the median are not used
constexpr std::size_t kFewestRings = 3;

// The normal equations A x = b for one error per ring, solved by ridge regression: (A + kRidge a I) x = b, where a is
// the mean of A's diagonal. The ridge keeps errors small that the patches do not determine: an error common to all
// rings of a patch is not observable, and an error that changes slowly from ring to ring hardly is.
struct RingSystem {
  explicit RingSystem(Eigen::Index rings) : a(Eigen::MatrixXd::Zero(rings, rings)), b(Eigen::VectorXd::Zero(rings)) {}

  Eigen::LDLT<Eigen::MatrixXd> factor() const {
    const Eigen::VectorXd ridge = Eigen::VectorXd::Constant(a.rows(), kRidge * a.diagonal().mean());
    return Eigen::LDLT<Eigen::MatrixXd>(a + Eigen::MatrixXd(ridge.asDiagonal()));
  }
  Eigen::VectorXd solve() const { return factor().solve(b); }
  // Returns the matrix that maps true errors to the solution; not the identity matrix, since the ridge shrinks errors.
  Eigen::MatrixXd resolution() const { return factor().solve(a); }
  bool contains(Eigen::Index ring) const { return a(ring, ring) > 0; }

  Eigen::MatrixXd a;
  Eigen::VectorXd b;
};

// A measured value of one return of a patch.
struct RingValue {
  std::uint32_t ring;
  double value;
  // The derivatives of the value with respect to what is fitted to each patch separately: a plane for ranges; a
  // constant and a slope over the rows for intensities (the third derivative is then 0).
  Vec3d design;
};

struct PatchValues {
  std::vector<RingValue> ranges;          // differences of ranges from the patch's plane (m)
  std::vector<RingValue> logIntensities;  // natural logarithms of the intensities above 0
};

// Returns the values of a patch. Ignores ranges far from the plane if the patch has at least kFewestBeams returns.
PatchValues valuesOf(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan, const FlatPatch& patch) {
  PatchValues values;
  std::vector<double> distances;  // absolute distances from the plane (m)
  for (std::uint32_t row = 0; row < kPatchRings; ++row) {
    for (std::uint32_t column = 0; column < kPatchColumns; ++column) {
      const auto beam = image.beam(patch.window.row + row, patch.window.column + column);
      if (!beam || !std::isfinite(scan.range[*beam])) continue;
      const double onPlane = rangeOnPlane(beams, *beam, patch.plane);
      if (!(onPlane > 0)) continue;
      const std::uint32_t ring = *beam / beams.columns;
      // The derivative of a range r by the plane's vector is -r^2 times the beam's direction; the sign has no effect.
      values.ranges.push_back({ring, scan.range[*beam] - onPlane, beams.direction[*beam] * (onPlane * onPlane)});
      distances.push_back(std::abs(values.ranges.back().value));
      if (!scan.intensity.empty() && scan.intensity[*beam] > 0) {
        values.logIntensities.push_back(
            {ring, std::log(double{scan.intensity[*beam]}), {1, static_cast<double>(row), 0}});
      }
    }
  }
  if (values.ranges.size() < kFewestBeams) return values;
  const double largest = kOutlier * medianOf(std::move(distances)) + 1e-6;
  std::erase_if(values.ranges, [&](const RingValue& v) { return std::abs(v.value) > largest; });
  return values;
}

// Adds the values of a patch to the normal equations, without the part that the patch's own plane or line explains.
// With the ring indicators E (1 in the column of the row's ring), the values v and the projection P onto what the
// patch's own fit leaves: A += E^T P E and b += E^T P v, since P is symmetric and idempotent. `terms`: number of
// entries of RingValue::design that are used.
void addTo(RingSystem& system, const std::vector<RingValue>& values, Eigen::Index terms) {
  const auto rows = static_cast<Eigen::Index>(values.size());
  Eigen::MatrixXd columns(rows, terms);
  std::vector<std::uint32_t> rings;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RingValue& v = values[static_cast<std::size_t>(i)];
    columns.row(i) = Eigen::RowVector3d(v.design.x, v.design.y, v.design.z).head(terms);
    rings.push_back(v.ring);
  }
  std::ranges::sort(rings);
  rings.erase(std::unique(rings.begin(), rings.end()), rings.end());
  const auto ringCount = static_cast<Eigen::Index>(rings.size());
  Eigen::MatrixXd residuals(rows, ringCount + 1);  // E, then v; after the fit P E, then P v
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RingValue& v = values[static_cast<std::size_t>(i)];
    residuals(i, ringCount) = v.value;
    for (Eigen::Index k = 0; k < ringCount; ++k) residuals(i, k) = v.ring == rings[static_cast<std::size_t>(k)] ? 1 : 0;
  }
  residuals -= columns * columns.completeOrthogonalDecomposition().solve(residuals).eval();
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto ring = static_cast<Eigen::Index>(values[static_cast<std::size_t>(i)].ring);
    for (Eigen::Index k = 0; k < ringCount; ++k) system.a(ring, rings[static_cast<std::size_t>(k)]) += residuals(i, k);
    system.b[ring] += residuals(i, ringCount);
  }
}

// Returns the errors of the rings, from the equations of all patches. Finds their spread and agreement by comparing the
// odd with the even patches, which shows which part of the errors is noise. `halves`: the equations of the even and of
// the odd patches.
RingSpread ringSpreadOf(const std::array<RingSystem, 2>& halves) {
  RingSystem both = halves[0];
  both.a += halves[1].a;
  both.b += halves[1].b;
  const Eigen::VectorXd errors = both.solve();
  RingSpread spread;
  spread.ofRing.assign(errors.begin(), errors.end());
  std::vector<Eigen::Index> ringsInBoth;
  for (Eigen::Index ring = 0; ring < errors.size(); ++ring) {
    if (halves[0].contains(ring) && halves[1].contains(ring)) ringsInBoth.push_back(ring);
  }
  spread.rings = ringsInBoth.size();
  if (spread.rings < kFewestRings) return spread;
  // Returns the errors, according to one half, of the rings in both halves, minus their mean.
  const auto centredErrors = [&](const RingSystem& half) -> Eigen::VectorXd {
    const Eigen::VectorXd ofRings = half.solve()(ringsInBoth);
    return ofRings.array() - ofRings.mean();
  };
  const Eigen::VectorXd even = centredErrors(halves[0]), odd = centredErrors(halves[1]);
  const double covariance = even.dot(odd) / static_cast<double>(spread.rings);
  // The covariance that the solutions of the halves have if the rings' true errors are independent with variance 1.
  const double unitCovariance =
      halves[0].resolution().cwiseProduct(halves[1].resolution()).sum() / static_cast<double>(spread.rings);
  spread.sigma = unitCovariance > 0 ? std::sqrt(std::max(0.0, covariance) / unitCovariance) : 0;
  spread.agreement = even.norm() > 0 && odd.norm() > 0 ? even.dot(odd) / (even.norm() * odd.norm()) : 0;
  return spread;
}

}  // namespace

RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<const FlatPatch*>& patches) {
  const BeamImage image(beams);
  const RingSystem empty(beams.rings);
  // Equations of the ranges and of the gains: one system each for the even and for the odd patches.
  std::array<RingSystem, 2> ranges{empty, empty}, gains{empty, empty};
  bool hasIntensities = false;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const PatchValues values = valuesOf(beams, image, scans[patches[p]->window.scan], *patches[p]);
    if (values.ranges.size() >= kFewestBeams) addTo(ranges[p % 2], values.ranges, 3);  // a plane
    if (values.logIntensities.size() < kFewestBeams) continue;
    hasIntensities = true;
    addTo(gains[p % 2], values.logIntensities, 2);  // a constant and a slope
  }
  RingErrors errors;
  errors.range = ringSpreadOf(ranges);
  if (hasIntensities) errors.gain = ringSpreadOf(gains);
  return errors;
}

}  // namespace scanmill
