#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "evaluate/spread.h"
#include "study/noise/fit_noise.h"

namespace scanmill {

namespace {

constexpr std::size_t kFewestBeams = 20;  // a patch with fewer returns is not used
constexpr double kRidge = 0.1;
constexpr double kFarOff = 5;  // residuals larger than this multiple of their patch's median deviation are not used

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
  // Returns the matrix that maps true errors to the solution. It differs from the identity, since the ridge shrinks
  // errors.
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
  // constant and a slope over the rows for intensities (the third is 0).
  Vec3d design;
};

struct PatchValues {
  std::vector<RingValue> ranges;          // differences of ranges from the patch's plane (m)
  std::vector<RingValue> logIntensities;  // natural logarithms of the intensities above 0
};

PatchValues valuesOf(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan, const FlatPatch& patch) {
  PatchValues found;
  std::vector<double> sizes;
  for (std::uint32_t row = 0; row < kPatchRings; ++row) {
    for (std::uint32_t column = 0; column < kPatchColumns; ++column) {
      const auto beam = image.beam(patch.window.row + row, patch.window.column + column);
      if (!beam || !std::isfinite(scan.range[*beam])) continue;
      const double onPlane = rangeOnPlane(beams, *beam, patch.plane);
      if (!(onPlane > 0)) continue;
      const std::uint32_t ring = *beam / beams.columns;
      found.ranges.push_back({ring, scan.range[*beam] - onPlane, beams.direction[*beam] * (onPlane * onPlane)});
      sizes.push_back(std::abs(found.ranges.back().value));
      if (!scan.intensity.empty() && scan.intensity[*beam] > 0) {
        found.logIntensities.push_back(
            {ring, std::log(double{scan.intensity[*beam]}), {1, static_cast<double>(row), 0}});
      }
    }
  }
  if (found.ranges.size() < kFewestBeams) return found;
  const double most = kFarOff * medianOf(std::move(sizes)) + 1e-6;
  std::erase_if(found.ranges, [&](const RingValue& v) { return std::abs(v.value) > most; });
  return found;
}

// Adds the values of a patch to the normal equations, without the part that the patch's own plane or line explains.
// `terms`: number of entries of RingValue::design that are used.
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
  const auto own = static_cast<Eigen::Index>(rings.size());
  Eigen::MatrixXd residuals(rows, own + 1);  // one indicator column per ring, then the values
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RingValue& v = values[static_cast<std::size_t>(i)];
    residuals(i, own) = v.value;
    for (Eigen::Index k = 0; k < own; ++k) residuals(i, k) = v.ring == rings[static_cast<std::size_t>(k)] ? 1 : 0;
  }
  residuals -= columns * columns.completeOrthogonalDecomposition().solve(residuals).eval();
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto to = static_cast<Eigen::Index>(values[static_cast<std::size_t>(i)].ring);
    for (Eigen::Index k = 0; k < own; ++k) system.a(to, rings[static_cast<std::size_t>(k)]) += residuals(i, k);
    system.b[to] += residuals(i, own);
  }
}

// Computes the ring errors from the equations of the odd and the even patches. Comparing both shows which part is
// noise.
RingSpread ringSpreadOf(const std::array<RingSystem, 2>& half) {
  RingSystem both = half[0];
  both.a += half[1].a;
  both.b += half[1].b;
  RingSpread spread;
  const Eigen::VectorXd solved = both.solve();
  spread.ofRing.assign(solved.begin(), solved.end());
  std::vector<Eigen::Index> inBoth;
  for (Eigen::Index ring = 0; ring < solved.size(); ++ring) {
    if (half[0].contains(ring) && half[1].contains(ring)) inBoth.push_back(ring);
  }
  spread.rings = inBoth.size();
  if (spread.rings < 3) return spread;
  const auto n = static_cast<double>(spread.rings);
  const auto aboutMean = [&](const RingSystem& system) -> Eigen::VectorXd {
    const Eigen::VectorXd errors = system.solve()(inBoth);
    return errors.array() - errors.mean();
  };
  const Eigen::VectorXd a = aboutMean(half[0]), b = aboutMean(half[1]);
  // The covariance between the halves' solutions if true errors are independent with variance 1.
  const double unitCovariance = half[0].resolution().cwiseProduct(half[1].resolution()).sum() / n;
  spread.sigma = unitCovariance > 0 ? std::sqrt(std::max(0.0, a.dot(b) / n) / unitCovariance) : 0;
  spread.agreement = a.norm() > 0 && b.norm() > 0 ? a.dot(b) / (a.norm() * b.norm()) : 0;
  return spread;
}

}  // namespace

RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<FlatPatch>& patches) {
  const BeamImage image(beams);
  const RingSystem none(beams.rings);
  // Equations of the ranges and of the gains: one system each for the odd and for the even patches.
  std::array<RingSystem, 2> ranges{none, none}, gains{none, none};
  bool lit = false;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const PatchValues values = valuesOf(beams, image, scans[patches[p].window.scan], patches[p]);
    if (values.ranges.size() >= kFewestBeams) addTo(ranges[p % 2], values.ranges, 3);
    if (values.logIntensities.size() < kFewestBeams) continue;
    lit = true;
    addTo(gains[p % 2], values.logIntensities, 2);
  }
  RingErrors errors;
  errors.range = ringSpreadOf(ranges);
  if (lit) errors.gain = ringSpreadOf(gains);
  return errors;
}

}  // namespace scanmill
