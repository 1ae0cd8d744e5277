#include "study/noise/ring_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace scanmill {

namespace {

constexpr std::size_t kFewestBeams = 20;  // returns of a patch that are used
constexpr double kRidge = 0.1;
constexpr double kFarOff = 5;  // residuals beyond so many median deviations of their patch are left out

// The normal equations of one error a ring, A x = b, as ridge regression: (A + kRidge a I) x = b, with a the mean of
// A's diagonal. What all rings of a patch share cannot be seen, and what changes slowly from ring to ring hardly: the
// ridge keeps both from growing. Solved by conjugate gradients.
class RingSystem {
 public:
  explicit RingSystem(std::size_t rings) : rings_(rings), a_(rings * rings, 0.0), b_(rings, 0.0) {}

  void add(const std::vector<std::uint32_t>& ring, const std::vector<double>& projected,
           const std::vector<std::vector<double>>& projectedOnes, const std::vector<std::uint32_t>& rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) b_[ring[i]] += projected[i];
    for (std::size_t k = 0; k < rings.size(); ++k) {
      for (std::size_t i = 0; i < ring.size(); ++i) a_[ring[i] * rings_ + rings[k]] += projectedOnes[k][i];
    }
  }

  std::vector<double> solve() const { return solve(b_); }

  // What the solution makes of the true errors, which it shrinks: the matrix (A + kRidge a I)^-1 A, row by row.
  std::vector<double> resolution() const {
    std::vector<double> whole(rings_ * rings_);
    std::vector<double> column(rings_);
    for (std::size_t j = 0; j < rings_; ++j) {
      for (std::size_t i = 0; i < rings_; ++i) column[i] = a_[i * rings_ + j];
      const std::vector<double> solved = solve(column);
      for (std::size_t i = 0; i < rings_; ++i) whole[i * rings_ + j] = solved[i];
    }
    return whole;
  }

  bool tellsOf(std::size_t ring) const { return a_[ring * rings_ + ring] > 0; }

 private:
  std::vector<double> solve(const std::vector<double>& right) const {
    std::vector<double> x(rings_, 0.0);
    std::vector<double> r = right;
    std::vector<double> p = r;
    double square = dot(r, r);
    const double least = 1e-20 * square;
    for (std::size_t step = 0; step < 10 * rings_ && square > least; ++step) {
      const std::vector<double> ap = times(p);
      const double along = dot(p, ap);
      if (along <= 0) break;
      const double length = square / along;
      for (std::size_t i = 0; i < rings_; ++i) {
        x[i] += length * p[i];
        r[i] -= length * ap[i];
      }
      const double next = dot(r, r);
      for (std::size_t i = 0; i < rings_; ++i) p[i] = r[i] + next / square * p[i];
      square = next;
    }
    return x;
  }

  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  }
  std::vector<double> times(const std::vector<double>& v) const {
    double diagonal = 0;
    for (std::size_t i = 0; i < rings_; ++i) diagonal += a_[i * rings_ + i];
    std::vector<double> out = v;
    for (double& value : out) value *= kRidge * diagonal / static_cast<double>(rings_);
    for (std::size_t i = 0; i < rings_; ++i) {
      for (std::size_t j = 0; j < rings_; ++j) out[i] += a_[i * rings_ + j] * v[j];
    }
    return out;
  }

  std::size_t rings_;
  std::vector<double> a_;
  std::vector<double> b_;
};

// Takes out of the values what a combination of the columns explains: modified Gram and Schmidt.
class Projector {
 public:
  explicit Projector(std::vector<std::vector<double>> columns) {
    for (std::vector<double>& column : columns) {
      const double before = norm(column);
      takeOut(column);
      const double left = norm(column);
      if (!(left > 1e-9 * before)) continue;
      for (double& value : column) value /= left;
      basis_.push_back(std::move(column));
    }
  }

  void takeOut(std::vector<double>& values) const {
    for (const std::vector<double>& q : basis_) {
      const double along = std::inner_product(q.begin(), q.end(), values.begin(), 0.0);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] -= along * q[i];
    }
  }

 private:
  static double norm(const std::vector<double>& v) {
    return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0));
  }
  std::vector<std::vector<double>> basis_;
};

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What one patch says: of each return its ring, the difference from the patch's plane and how that changes with the
// plane; and the logarithm of the intensity.
struct PatchView {
  std::vector<std::uint32_t> ring;
  std::vector<double> difference;
  std::array<std::vector<double>, 3> slope;
  std::vector<double> brightness;  // of those with an intensity
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
      const double square = onPlane * onPlane;
      all.slope[0].push_back(square * direction.x);
      all.slope[1].push_back(square * direction.y);
      all.slope[2].push_back(square * direction.z);
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
    for (std::size_t k = 0; k < 3; ++k) kept.slope[k].push_back(all.slope[k][i]);
  }
  return kept;
}

void addTo(RingSystem& system, const std::vector<std::uint32_t>& ring, std::vector<double> values,
           const Projector& projector) {
  std::vector<std::uint32_t> rings = ring;
  std::sort(rings.begin(), rings.end());
  rings.erase(std::unique(rings.begin(), rings.end()), rings.end());
  projector.takeOut(values);
  std::vector<std::vector<double>> ones;
  for (const std::uint32_t r : rings) {
    std::vector<double> column(ring.size());
    for (std::size_t i = 0; i < ring.size(); ++i) column[i] = ring[i] == r ? 1 : 0;
    projector.takeOut(column);
    ones.push_back(std::move(column));
  }
  system.add(ring, values, ones, rings);
}

// From all patches, and from the odd and the even ones.
struct ThreeSystems {
  explicit ThreeSystems(std::size_t rings) : all(rings), half{RingSystem(rings), RingSystem(rings)} {}
  RingSystem all;
  std::array<RingSystem, 2> half;

  RingSpread spread(std::size_t rings) const {
    RingSpread made;
    made.ofRing = all.solve();
    const std::vector<double> a = half[0].solve();
    const std::vector<double> b = half[1].solve();
    double sums[5] = {0, 0, 0, 0, 0};
    for (std::size_t ring = 0; ring < rings; ++ring) {
      if (!half[0].tellsOf(ring) || !half[1].tellsOf(ring)) continue;
      ++made.rings;
      sums[0] += a[ring];
      sums[1] += b[ring];
      sums[2] += a[ring] * a[ring];
      sums[3] += b[ring] * b[ring];
      sums[4] += a[ring] * b[ring];
    }
    if (made.rings < 3) return made;
    const auto n = static_cast<double>(made.rings);
    const double both = sums[4] / n - sums[0] / n * (sums[1] / n);
    const double varianceA = sums[2] / n - sums[0] / n * (sums[0] / n);
    const double varianceB = sums[3] / n - sums[1] / n * (sums[1] / n);
    // Independent errors of variance 1 would give the two halves this covariance.
    const std::vector<double> first = half[0].resolution();
    const std::vector<double> second = half[1].resolution();
    const double kept = std::inner_product(first.begin(), first.end(), second.begin(), 0.0) / n;
    made.sigma = kept > 0 ? std::sqrt(std::max(0.0, both) / kept) : 0;
    made.agreement = varianceA > 0 && varianceB > 0 ? both / std::sqrt(varianceA * varianceB) : 0;
    return made;
  }
};

}  // namespace

RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<FlatPatch>& patches) {
  const BeamImage image(beams);
  ThreeSystems ranges(beams.rings);
  ThreeSystems gains(beams.rings);
  bool lit = false;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const PatchView view = viewOf(beams, image, scans[patches[p].window.scan], patches[p]);
    if (view.ring.size() >= kFewestBeams) {
      const Projector plane({view.slope[0], view.slope[1], view.slope[2]});
      addTo(ranges.all, view.ring, view.difference, plane);
      addTo(ranges.half[p % 2], view.ring, view.difference, plane);
    }
    if (view.brightness.size() >= kFewestBeams) {
      lit = true;
      const Projector mean({std::vector<double>(view.brightness.size(), 1.0), view.brightRow});
      addTo(gains.all, view.brightRing, view.brightness, mean);
      addTo(gains.half[p % 2], view.brightRing, view.brightness, mean);
    }
  }
  RingErrors errors;
  errors.range = ranges.spread(beams.rings);
  if (lit) errors.gain = gains.spread(beams.rings);
  return errors;
}

}  // namespace scanmill
