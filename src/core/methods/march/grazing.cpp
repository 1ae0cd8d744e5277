// Decides what became of candidates for grazing hits: particles that came near a surface and moved away again.
//
// Candidates are settled many at a time. What they look at lies anywhere in memory: corners of the field, then
// triangles, then vertices. Each of these is prefetched for all candidates before the first candidate needs it.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "methods/march/march.h"
#include "methods/march/march_rule.h"

namespace scanmill {

namespace {

constexpr double kHalf = 0.5;    // voxels: a triangle so near is hit
constexpr double kAround = 1.5;  // voxels: so far from the candidate's place it may have crossed something
// The field is looked up at the candidate's place, and so far before and after it; voxels.
constexpr std::array<double, 3> kLooks{-0.8, 0.0, 0.8};

constexpr double kNowhere = std::numeric_limits<double>::infinity();

struct Corners {
  Vec3d a, b, c;
};

Corners cornersOf(const TriangleBlock& block, std::uint32_t triangle) {
  const Triangle& t = block.corners[triangle];
  return {Vec3d(block.vertices[t[0]]), Vec3d(block.vertices[t[1]]), Vec3d(block.vertices[t[2]])};
}

// Square of the distance from a point to an edge of a triangle; `s`: from the edge's beginning to the point. An edge of
// no length is a point.
double toEdge(const Vec3d& s, const Vec3d& edge) {
  const double share = dot(s, edge) / dot(edge, edge);
  const double along = share > 0 ? (share < 1 ? share : 1) : 0;
  const Vec3d away = s - edge * along;
  return dot(away, away);
}

struct GrazingCandidate {
  std::uint32_t particle;
  double way;   // field frame
  double grow;  // voxels of level 0 to one of the level
  double size;  // m, of these
  double low;   // m from the point: it may not cross before
  Vec3d d;
  Vec3d point;       // m, the world's frame
  std::size_t last;  // of its pairs with triangles: one past
};

// From a voxel's first corner to the others that begin its edges along x.
constexpr std::array<std::uint32_t, 4> kRows{0, kBrickCorners, kBrickCorners* kBrickCorners,
                                             kBrickCorners* kBrickCorners + kBrickCorners};

constexpr std::size_t kCandidatesAtOnce = 16;
constexpr std::size_t kWords = 8 * kLooks.size();

// Pairs of a candidate and a triangle that the field names there, candidate by candidate, in double.
struct PairLanes {
  using Values = double[kCandidatesAtOnce * kWords];
  alignas(64) Values sx, sy, sz;  // m, from the triangle's first corner to the candidate's point
  alignas(64) Values ux, uy, uz;  // m, to its second corner
  alignas(64) Values vx, vy, vz;  // m, to its third
  alignas(64) Values dx, dy, dz;  // of the particle's line
  alignas(64) Values low, high;   // m from the point: where the line may cross
  alignas(64) Values crossing;    // m, from the point; see compare()
  alignas(64) Values distance;    // m
};

// Where the line crosses the triangle (Moeller and Trumbore 1997), m from the point, infinite where it does not; and
// how far the point is from the triangle, m: from its plane where the perpendicular meets it, else from its edges.
void compare(PairLanes& l, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d s{l.sx[i], l.sy[i], l.sz[i]};
    const Vec3d ab{l.ux[i], l.uy[i], l.uz[i]};
    const Vec3d ac{l.vx[i], l.vy[i], l.vz[i]};
    const Vec3d d{l.dx[i], l.dy[i], l.dz[i]};
    const Vec3d p = cross(d, ac);
    const Vec3d q = cross(s, ab);
    const double determinant = dot(ab, p);
    const double sign = determinant < 0 ? -1 : 1;
    const double u = dot(s, p) * sign;
    const double v = dot(d, q) * sign;
    const double at = dot(ac, q) / determinant;
    const bool inside = (u >= 0) & (v >= 0) & (u + v <= determinant * sign);
    const bool there = inside & (at >= l.low[i]) & (at <= l.high[i]);
    l.crossing[i] = there ? at : kNowhere;
    const Vec3d normal = cross(ab, ac);
    const double square = dot(normal, normal);
    const double beyondAc = dot(normal, cross(s, ac));
    const double beyondAb = dot(normal, cross(ab, s));
    const bool above = (square > 0) & (beyondAc >= 0) & (beyondAb >= 0) & (beyondAc + beyondAb <= square);
    const double height = dot(normal, s);
    const double edges = std::min(std::min(toEdge(s, ab), toEdge(s, ac)), toEdge(s - ab, ac - ab));
    l.distance[i] = std::sqrt(above ? height * height / square : edges);
  }
}

class Round {
 public:
  Round(const DistanceField& field, const TriangleBlock& block)
      : field_(field), block_(block), voxel_(field.shape.voxel) {}

  // Looks at candidates, kCandidatesAtOnce at most.
  void look(const Particles& particles, const HitRecords& records, std::span<const std::uint32_t> at) {
    count_ = at.size();
    for (std::size_t b = 0; b < count_; ++b) place(particles, records, at[b], b);
    for (std::size_t b = 0; b < count_; ++b) read(b);
    std::size_t named = 0;
    for (std::size_t b = 0; b < count_; ++b) named = candidates_[b].last = name(words_[b], named);
    for (std::size_t k = 0; k < named; ++k) {
      for (const std::uint32_t corner : block_.corners[triangle_[k]]) __builtin_prefetch(&block_.vertices[corner]);
    }
    std::size_t first = 0;
    for (std::size_t b = 0; b < count_; first = candidates_[b++].last) {
      for (std::size_t k = first; k < candidates_[b].last; ++k) pair(candidates_[b], k);
    }
    compare(pairs_, named);
  }

  // The triangle that the b-th of them met; kNoWord where it met none.
  std::uint32_t triangleAt(std::size_t b, HitRecords& records) const {
    const GrazingCandidate& candidate = candidates_[b];
    const std::size_t first = b == 0 ? 0 : candidates_[b - 1].last;
    double crossed = kNowhere;  // m, from the candidate's point
    std::uint32_t triangle = kNoWord;
    for (std::size_t k = first; k < candidate.last; ++k) {
      triangle = pairs_.crossing[k] < crossed ? triangle_[k] : triangle;
      crossed = std::min(crossed, pairs_.crossing[k]);
    }
    if (triangle != kNoWord) {
      records.way[candidate.particle] = static_cast<float>(candidate.way + crossed / voxel_);
      return triangle;
    }
    double nearest = kHalf * candidate.size;
    for (std::size_t k = candidate.last; k-- > first;) {
      triangle = pairs_.distance[k] <= nearest ? triangle_[k] : triangle;
      nearest = std::min(nearest, pairs_.distance[k]);
    }
    return triangle;
  }

  const GrazingCandidate& candidate(std::size_t b) const { return candidates_[b]; }

 private:
  void place(const Particles& particles, const HitRecords& records, std::uint32_t i, std::size_t b) {
    const Vec3d o{particles.ox[i], particles.oy[i], particles.oz[i]};
    const Vec3d d{particles.dx[i], particles.dy[i], particles.dz[i]};
    const double way = records.way[i];
    const Vec3d at = o + d * way;
    const double grow = voxelAt(field_, Vec3f(at)) / voxel_;
    const double size = grow * voxel_;
    const double low = std::max(-kAround * size, (particles.begin[i] - way) * voxel_);
    candidates_[b] = {i, way, grow, size, low, d, field_.shape.centre + at * voxel_, 0};
    for (std::size_t k = 0; k < kLooks.size(); ++k) {
      const std::uint32_t cell = voxelCorner(field_, Vec3f(at + d * (kLooks[k] * grow)));
      cell_[b][k] = cell;
      if (cell == kNoWord) continue;
      for (const std::uint32_t row : kRows) __builtin_prefetch(&field_.word[cell + row]);
    }
  }

  void read(std::size_t b) {
    std::uint32_t* words = words_[b];
    for (const std::uint32_t cell : cell_[b]) {
      for (const std::uint32_t row : kRows) {
        *words++ = cell == kNoWord ? kNoWord : field_.word[cell + row];
        *words++ = cell == kNoWord ? kNoWord : field_.word[cell + row + 1];
      }
    }
  }

  // Each of the words that is a triangle once, to triangle_ from `first` on; where that ends.
  std::size_t name(const std::uint32_t (&words)[kWords], std::size_t first) {
    alignas(64) std::uint32_t left[kWords];
    for (std::uint32_t k = 0; k < kWords; ++k) left[k] = words[k] == kNoWord;
    for (std::uint32_t k = 0; k + 1 < kWords; ++k) {
      const std::uint32_t word = words[k];
      for (std::uint32_t j = 0; j < kWords; ++j) left[j] |= static_cast<std::uint32_t>((words[j] == word) & (j > k));
    }
    std::uint32_t named = 0;
    for (std::uint32_t k = 0; k < kWords; ++k) named |= (left[k] ^ 1) << k;
    for (; named != 0; named &= named - 1) {
      const std::uint32_t triangle = words[std::countr_zero(named)];
      __builtin_prefetch(&block_.corners[triangle]);
      triangle_[first++] = triangle;
    }
    return first;
  }

  void pair(const GrazingCandidate& candidate, std::size_t k) {
    const Corners t = cornersOf(block_, triangle_[k]);
    const Vec3d s = candidate.point - t.a;
    const Vec3d ab = t.b - t.a;
    const Vec3d ac = t.c - t.a;
    pairs_.sx[k] = s.x;
    pairs_.sy[k] = s.y;
    pairs_.sz[k] = s.z;
    pairs_.ux[k] = ab.x;
    pairs_.uy[k] = ab.y;
    pairs_.uz[k] = ab.z;
    pairs_.vx[k] = ac.x;
    pairs_.vy[k] = ac.y;
    pairs_.vz[k] = ac.z;
    pairs_.dx[k] = candidate.d.x;
    pairs_.dy[k] = candidate.d.y;
    pairs_.dz[k] = candidate.d.z;
    pairs_.low[k] = candidate.low;
    pairs_.high[k] = kAround * candidate.size;
  }

  const DistanceField& field_;
  const TriangleBlock& block_;
  double voxel_;
  std::size_t count_ = 0;
  std::array<GrazingCandidate, kCandidatesAtOnce> candidates_;
  std::uint32_t cell_[kCandidatesAtOnce][kLooks.size()];  // of the looks: voxelCorner()
  alignas(64) std::uint32_t words_[kCandidatesAtOnce][kWords];
  std::uint32_t triangle_[kCandidatesAtOnce * kWords];  // of the pairs
  PairLanes pairs_;
};

}  // namespace

void settleGrazing(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
                   Particles& particles, std::span<const std::uint32_t> at, HitRecords& records) {
  Round round(field, triangles);
  std::vector<std::uint32_t> open;
  for (const std::uint32_t i : at) {
    if (records.outcomeOf(i) == Outcome::Grazing) open.push_back(i);
  }
  while (!open.empty()) {
    std::vector<std::uint32_t> next;
    for (std::size_t first = 0; first < open.size(); first += kCandidatesAtOnce) {
      const auto some =
          std::span<const std::uint32_t>(open).subspan(first, std::min(kCandidatesAtOnce, open.size() - first));
      round.look(particles, records, some);
      for (std::size_t b = 0; b < some.size(); ++b) {
        const std::uint32_t i = some[b];
        const std::uint32_t taken = records.stepsOf(i);
        const std::uint32_t triangle = round.triangleAt(b, records);
        if (triangle != kNoWord) {
          records.triangle[i] = triangle;
          records.outcome[i] = static_cast<std::uint32_t>(Outcome::Hit) + 4 * taken;
          continue;
        }
        MarchOptions rest = options;
        rest.steps = options.steps > taken ? options.steps - taken : 0;
        particles.begin[i] = static_cast<float>(round.candidate(b).way + double{kGrazing} * round.candidate(b).grow);
        const HitRecord record = marchOne(field, triangles, rest, particles, i);
        records.way[i] = record.way;
        records.triangle[i] = record.triangle;
        records.outcome[i] = static_cast<std::uint32_t>(record.outcome) + 4 * (record.steps + taken);
        if (record.outcome == Outcome::Grazing) next.push_back(i);
      }
    }
    open.swap(next);
  }
}

}  // namespace scanmill
