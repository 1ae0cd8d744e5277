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

// The normal equations A x = b for one or two kinds of errors per ring, solved by ridge regression: (A + R) x = b. The
// unknowns are all errors of the first kind, by ring, then all of the second; the diagonal matrix R has kRidge times
// the mean of A's diagonal over the kind. The ridge keeps errors small that the patches do not determine: an error
// common to all rings of a patch is not observable, and an error that changes slowly from ring to ring hardly is.
struct RingSystem {
  RingSystem(Eigen::Index ringCount, Eigen::Index kindCount)
      : rings(ringCount),
        kinds(kindCount),
        a(Eigen::MatrixXd::Zero(rings * kinds, rings * kinds)),
        b(Eigen::VectorXd::Zero(rings * kinds)) {}

  Eigen::LDLT<Eigen::MatrixXd> factor() const {
    Eigen::VectorXd ridge(a.rows());
    for (Eigen::Index kind = 0; kind < kinds; ++kind) {
      ridge.segment(kind * rings, rings).setConstant(kRidge * a.diagonal().segment(kind * rings, rings).mean());
    }
    return Eigen::LDLT<Eigen::MatrixXd>(a + Eigen::MatrixXd(ridge.asDiagonal()));
  }
  Eigen::VectorXd solve() const { return factor().solve(b); }
  // Returns the matrix that maps true errors to the solution; not the identity matrix, since the ridge shrinks errors.
  Eigen::MatrixXd resolution() const { return factor().solve(a); }
  bool contains(Eigen::Index ring) const { return a(ring, ring) > 0; }

  Eigen::Index rings, kinds;
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
};

// A measured value of one return of a patch.
struct RingValue {
  std::uint32_t ring;
  double value;         // of a range: without the part that the point's elevation above its beam explains
  double perElevation;  // of a range: its derivative by the beam's elevation (m/rad)
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
      // The derivative of a range r by the beam's elevation is -r (n . u') / (n . u), with the derivative u' of the
      // beam's direction u.
      const Vec3d u = beams.direction[*beam];
      const double perElevation = -onPlane * dot(patch.plane, upwardsFrom(u)) / dot(patch.plane, u);
      const double difference = scan.range[*beam] - onPlane - perElevation * scan.raised[*beam];
      values.ranges.push_back({ring, difference, perElevation, u * (onPlane * onPlane)});
      distances.push_back(std::abs(values.ranges.back().value));
      if (!scan.intensity.empty() && scan.intensity[*beam] > 0) {
        values.logIntensities.push_back(
            {ring, std::log(double{scan.intensity[*beam]}), 0, {1, static_cast<double>(row), 0}});
      }
    }
  }
  if (values.ranges.size() < kFewestBeams) return values;
  const double largest = kOutlier * medianOf(std::move(distances)) + 1e-6;
  std::erase_if(values.ranges, [&](const RingValue& v) { return std::abs(v.value) > largest; });
  return values;
}

// Adds the values of a patch to the normal equations, without the part that the patch's own plane or line explains.
// With the derivatives E of the values by the rings' errors (for offsets, 1 in the column of the row's ring), the
// values v and the projection P onto what the patch's own fit leaves: A += w E^T P E and b += w E^T P v, since P is
// symmetric and idempotent. `terms`: number of entries of RingValue::design that are used; `weight`: w.
void addTo(RingSystem& system, const std::vector<RingValue>& values, Eigen::Index terms, double weight = 1) {
  const auto rows = static_cast<Eigen::Index>(values.size());
  Eigen::MatrixXd columns(rows, terms);
  std::vector<Eigen::Index> unknowns;  // those of the patch's rings
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RingValue& v = values[static_cast<std::size_t>(i)];
    columns.row(i) = Eigen::RowVector3d(v.design.x, v.design.y, v.design.z).head(terms);
    for (Eigen::Index kind = 0; kind < system.kinds; ++kind) unknowns.push_back(kind * system.rings + v.ring);
  }
  std::ranges::sort(unknowns);
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd derivatives(rows, count + 1);  // E, then v
  for (Eigen::Index i = 0; i < rows; ++i) {
    const RingValue& v = values[static_cast<std::size_t>(i)];
    derivatives(i, count) = v.value;
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index unknown = unknowns[static_cast<std::size_t>(k)];
      const bool isOfRing = unknown % system.rings == v.ring;
      derivatives(i, k) = !isOfRing ? 0 : unknown < system.rings ? 1 : v.perElevation;
    }
  }
  const Eigen::MatrixXd residuals =
      derivatives - columns * columns.completeOrthogonalDecomposition().solve(derivatives).eval();
  const Eigen::MatrixXd products = weight * derivatives.leftCols(count).transpose() * residuals;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index unknown = unknowns[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < count; ++k) {
      system.a(unknown, unknowns[static_cast<std::size_t>(k)]) += products(i, k);
    }
    system.b[unknown] += products(i, count);
  }
}

// Returns the variances that explain the covariances: covariances = matrix * variances, with no variance below 0.
Eigen::VectorXd variancesOf(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& covariances) {
  Eigen::VectorXd variances = matrix.completeOrthogonalDecomposition().solve(covariances);
  Eigen::Index least = 0;
  if (variances.minCoeff(&least) >= 0) return variances;
  variances.setZero();
  const Eigen::Index other = variances.size() - 1 - least;
  if (other != least) variances[other] = std::max(0.0, covariances[other] / matrix(other, other));
  return variances;
}

// Returns the errors of the rings by kind, from the equations of all patches. Finds their spread and agreement by
// comparing the odd with the even patches, which shows which part of the errors is noise. `halves`: the equations of
// the even and of the odd patches.
std::vector<RingSpread> ringSpreadsOf(const std::array<RingSystem, 2>& halves) {
  RingSystem both = halves[0];
  both.a += halves[1].a;
  both.b += halves[1].b;
  const Eigen::Index rings = both.rings;
  const Eigen::VectorXd errors = both.solve();
  std::vector<Eigen::Index> ringsInBoth;
  for (Eigen::Index ring = 0; ring < rings; ++ring) {
    if (halves[0].contains(ring) && halves[1].contains(ring)) ringsInBoth.push_back(ring);
  }
  const std::array<Eigen::VectorXd, 2> solutions{halves[0].solve(), halves[1].solve()};
  // The covariance that the solutions of the halves have, by kind, if the rings' true errors of a kind are independent
  // with variance 1: errors of one kind appear in part as errors of the other.
  const Eigen::MatrixXd products = halves[0].resolution().cwiseProduct(halves[1].resolution());
  Eigen::MatrixXd unitCovariances(both.kinds, both.kinds);
  Eigen::VectorXd covariances(both.kinds);
  std::vector<RingSpread> spreads(static_cast<std::size_t>(both.kinds));
  for (Eigen::Index kind = 0; kind < both.kinds; ++kind) {
    RingSpread& spread = spreads[static_cast<std::size_t>(kind)];
    const Eigen::VectorXd ofKind = errors.segment(kind * rings, rings);
    spread.ofRing.assign(ofKind.begin(), ofKind.end());
    spread.rings = ringsInBoth.size();
    if (spread.rings < kFewestRings) return spreads;
    // Returns the errors, according to one half, of the rings in both halves, minus their mean.
    const auto centredErrors = [&](const Eigen::VectorXd& solution) -> Eigen::VectorXd {
      const Eigen::VectorXd ofRings = solution.segment(kind * rings, rings)(ringsInBoth);
      return ofRings.array() - ofRings.mean();
    };
    const Eigen::VectorXd even = centredErrors(solutions[0]), odd = centredErrors(solutions[1]);
    covariances[kind] = even.dot(odd) / static_cast<double>(spread.rings);
    spread.agreement = even.norm() > 0 && odd.norm() > 0 ? even.dot(odd) / (even.norm() * odd.norm()) : 0;
    for (Eigen::Index cause = 0; cause < both.kinds; ++cause) {
      unitCovariances(kind, cause) =
          products.block(kind * rings, cause * rings, rings, rings).sum() / static_cast<double>(spread.rings);
    }
  }
  const Eigen::VectorXd variances = variancesOf(unitCovariances, covariances);
  for (std::size_t kind = 0; kind < spreads.size(); ++kind) {
    spreads[kind].sigma = std::sqrt(std::max(0.0, variances[static_cast<Eigen::Index>(kind)]));
  }
  return spreads;
}

}  // namespace

RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<const FlatPatch*>& patches) {
  constexpr std::size_t kFewestOfEach = 30;  // upright and level patches that tell the two kinds apart
  constexpr double kMostUpright = 0.35;      // vertical component of a patch's normal, see kLeastLevel
  const auto countOf = [&](auto isKind) {
    return static_cast<std::size_t>(
        std::ranges::count_if(patches, [&](const FlatPatch* p) { return isKind(std::abs(normalized(p->plane).z)); }));
  };
  const bool separable = countOf([](double z) { return z < kMostUpright; }) >= kFewestOfEach &&
                         countOf([](double z) { return z > kLeastLevel; }) >= kFewestOfEach;
  const BeamImage image(beams);
  const RingSystem noRanges(beams.rings, separable ? 2 : 1), noGains(beams.rings, 1);
  // Equations of the ranges and of the gains: one system each for the even and for the odd patches.
  std::array<RingSystem, 2> ranges{noRanges, noRanges}, gains{noGains, noGains};
  bool hasIntensities = false;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const PatchValues values = valuesOf(beams, image, scans[patches[p]->window.scan], *patches[p]);
    if (values.ranges.size() >= kFewestBeams) {
      addTo(ranges[p % 2], values.ranges, 3, 1 / std::max(patches[p]->testedLines.variance(), 1e-8));  // a plane
    }
    // Grazing views are darker by more than the slope over a patch's rows explains.
    if (patches[p]->incidence < kSteep || values.logIntensities.size() < kFewestBeams) continue;
    hasIntensities = true;
    addTo(gains[p % 2], values.logIntensities, 2);  // a constant and a slope
  }
  RingErrors errors;
  const std::vector<RingSpread> spreads = ringSpreadsOf(ranges);
  errors.range = spreads.front();
  if (separable) errors.elevation = spreads.back();
  if (hasIntensities) errors.gain = ringSpreadsOf(gains).front();
  return errors;
}

}  // namespace scanmill
