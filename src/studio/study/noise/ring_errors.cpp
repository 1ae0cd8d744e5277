#include "study/noise/ring_errors.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "evaluate/spread.h"

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
  bool tellsOf(Eigen::Index ring) const { return a(ring, ring) > 0; }

  Eigen::MatrixXd a;
  Eigen::VectorXd b;
};

// The data of one patch.
struct PatchView {
  // For each return: its ring, the difference (m) of its range from the patch's plane, and the derivative of this
  // difference with respect to the plane.
  std::vector<std::uint32_t> ring;
  std::vector<double> difference;
  std::vector<Vec3d> slope;
  // For each return with an intensity above 0: the natural logarithm of the intensity, its ring, and its row in the
  // patch.
  std::vector<double> brightness;
  std::vector<std::uint32_t> brightRing;
  std::vector<double> brightRow;
};

PatchView viewOf(const BeamTable& beams, const BeamImage& image, const RecordedScan& scan, const FlatPatch& patch) {
  PatchView all;
  std::vector<double> sizes;
  for (std::uint32_t row = 0; row < kPatchRings; ++row) {
    for (std::uint32_t column = 0; column < kPatchColumns; ++column) {
      const auto beam = image.beam(patch.window.row + row, patch.window.column + column);
      if (!beam || !std::isfinite(scan.range[*beam])) continue;
      const double onPlane = rangeOnPlane(beams, *beam, patch.plane);
      if (!(onPlane > 0)) continue;
      const Vec3d& direction = beams.direction[*beam];
      all.ring.push_back(*beam / beams.columns);
      all.difference.push_back(double{scan.range[*beam]} - onPlane);
      sizes.push_back(std::abs(all.difference.back()));
      all.slope.push_back(direction * (onPlane * onPlane));
      if (!scan.intensity.empty() && scan.intensity[*beam] > 0) {
        all.brightness.push_back(std::log(double{scan.intensity[*beam]}));
        all.brightRing.push_back(all.ring.back());
        all.brightRow.push_back(row);
      }
    }
  }
  if (all.ring.size() < kFewestBeams) return all;
  const double most = kFarOff * medianOf(sizes) + 1e-6;
  PatchView kept;
  kept.brightness = std::move(all.brightness);
  kept.brightRing = std::move(all.brightRing);
  kept.brightRow = std::move(all.brightRow);
  for (std::size_t i = 0; i < all.ring.size(); ++i) {
    if (sizes[i] > most) continue;
    kept.ring.push_back(all.ring[i]);
    kept.difference.push_back(all.difference[i]);
    kept.slope.push_back(all.slope[i]);
  }
  return kept;
}

// Adds a patch to the normal equations. `ring`, `values`: ring and measured value of each return. `columns`: basis of
// the functions (a plane, or a line) that are fitted to each patch separately and removed from the values.
void addTo(RingSystem& system, const std::vector<std::uint32_t>& ring, const std::vector<double>& values,
           const Eigen::MatrixXd& columns) {
  std::vector<std::uint32_t> rings = ring;
  std::ranges::sort(rings);
  rings.erase(std::unique(rings.begin(), rings.end()), rings.end());
  const auto rows = static_cast<Eigen::Index>(ring.size()), own = static_cast<Eigen::Index>(rings.size());
  Eigen::MatrixXd left(rows, own + 1);  // one indicator column per ring, then the values
  for (Eigen::Index i = 0; i < rows; ++i) {
    left(i, own) = values[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < own; ++k) {
      left(i, k) = ring[static_cast<std::size_t>(i)] == rings[static_cast<std::size_t>(k)] ? 1 : 0;
    }
  }
  left -= columns * columns.completeOrthogonalDecomposition().solve(left).eval();
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto to = static_cast<Eigen::Index>(ring[static_cast<std::size_t>(i)]);
    for (Eigen::Index k = 0; k < own; ++k) system.a(to, rings[static_cast<std::size_t>(k)]) += left(i, k);
    system.b[to] += left(i, own);
  }
}

// Computes the ring errors from the equations of the odd and the even patches. Comparing both shows which part is
// noise.
RingSpread ringSpreadOf(const std::array<RingSystem, 2>& half) {
  RingSystem all = half[0];
  all.a += half[1].a;
  all.b += half[1].b;
  RingSpread made;
  const Eigen::VectorXd solved = all.solve();
  made.ofRing.assign(solved.begin(), solved.end());
  std::vector<Eigen::Index> told;
  for (Eigen::Index ring = 0; ring < solved.size(); ++ring) {
    if (half[0].tellsOf(ring) && half[1].tellsOf(ring)) told.push_back(ring);
  }
  made.rings = told.size();
  if (made.rings < 3) return made;
  const auto n = static_cast<double>(made.rings);
  const auto aboutMean = [&](const RingSystem& system) -> Eigen::VectorXd {
    const Eigen::VectorXd own = system.solve()(told);
    return own.array() - own.mean();
  };
  const Eigen::VectorXd a = aboutMean(half[0]), b = aboutMean(half[1]);
  // This is the covariance between the halves' solutions if true errors are independent with variance 1.
  const double kept = half[0].resolution().cwiseProduct(half[1].resolution()).sum() / n;
  made.sigma = kept > 0 ? std::sqrt(std::max(0.0, a.dot(b) / n) / kept) : 0;
  made.agreement = a.norm() > 0 && b.norm() > 0 ? a.dot(b) / (a.norm() * b.norm()) : 0;
  return made;
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
    const PatchView view = viewOf(beams, image, scans[patches[p].window.scan], patches[p]);
    if (view.ring.size() >= kFewestBeams) {
      Eigen::MatrixXd plane(static_cast<Eigen::Index>(view.ring.size()), 3);
      for (std::size_t i = 0; i < view.ring.size(); ++i) {
        plane.row(static_cast<Eigen::Index>(i)) << view.slope[i].x, view.slope[i].y, view.slope[i].z;
      }
      addTo(ranges[p % 2], view.ring, view.difference, plane);
    }
    if (view.brightness.size() >= kFewestBeams) {
      lit = true;
      Eigen::MatrixXd slope = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(view.brightness.size()), 2);
      slope.col(1) = Eigen::Map<const Eigen::VectorXd>(view.brightRow.data(), slope.rows());
      addTo(gains[p % 2], view.brightRing, view.brightness, slope);
    }
  }
  RingErrors errors;
  errors.range = ringSpreadOf(ranges);
  if (lit) errors.gain = ringSpreadOf(gains);
  return errors;
}

}  // namespace scanmill
