// What became of particles that were near a surface and moved away again.
//
// Brinks are settled many at a time. What they look at lies anywhere in memory, from corners of the field to triangles
// to vertices: each is asked for on behalf of all brinks before the first is needed.

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

constexpr double kHalf = 0.5;    // voxels: so near to a triangle a particle is at rest
constexpr double kAround = 1.5;  // voxels: so far from the brink it may have crossed something
// The field is asked at the brink and a step before and after it; voxels.
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

struct Brink {
  std::uint32_t particle;
  double way;   // field frame
  double grow;  // voxels of level 0 to one of the level
  double size;  // m, of these
  double low;   // m from the point: it may not cross before
  Vec3d d;
  Vec3d point;       // m, the world's frame
  std::size_t last;  // of its candidates: one past
};

// From a voxel's first corner to the others that begin its edges along x.
constexpr std::array<std::uint32_t, 4> kRows{0, kBrickCorners, kBrickCorners* kBrickCorners,
                                             kBrickCorners* kBrickCorners + kBrickCorners};

constexpr std::size_t kBrinksAtOnce = 16;
constexpr std::size_t kWords = 8 * kLooks.size();

// Pairs of a brink and a triangle that the field names there, brink by brink, in double.
struct PairLanes {
  using Values = double[kBrinksAtOnce * kWords];
  alignas(64) Values sx, sy, sz;  // m, from the triangle's first corner to the brink's point
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
  Round(const Field& field, const TriangleBlock& block) : field_(field), block_(block), voxel_(field.shape.voxel) {}

  // Looks at particles that are at brinks, kBrinksAtOnce at most.
  void look(const Particles& particles, const Landings& landings, std::span<const std::uint32_t> at) {
    count_ = at.size();
    for (std::size_t b = 0; b < count_; ++b) place(particles, landings, at[b], b);
    for (std::size_t b = 0; b < count_; ++b) read(b);
    std::size_t named = 0;
    for (std::size_t b = 0; b < count_; ++b) named = brinks_[b].last = name(words_[b], named);
    for (std::size_t k = 0; k < named; ++k) {
      for (const std::uint32_t corner : block_.corners[triangle_[k]]) __builtin_prefetch(&block_.vertices[corner]);
    }
    std::size_t first = 0;
    for (std::size_t b = 0; b < count_; first = brinks_[b++].last) {
      for (std::size_t k = first; k < brinks_[b].last; ++k) pair(brinks_[b], k);
    }
    compare(pairs_, named);
  }

  // What the b-th of them met: kNoWord where nothing.
  std::uint32_t triangleAt(std::size_t b, Landings& landings) const {
    const Brink& brink = brinks_[b];
    const std::size_t first = b == 0 ? 0 : brinks_[b - 1].last;
    double crossed = kNowhere;  // m, from the brink
    std::uint32_t triangle = kNoWord;
    for (std::size_t k = first; k < brink.last; ++k) {
      triangle = pairs_.crossing[k] < crossed ? triangle_[k] : triangle;
      crossed = std::min(crossed, pairs_.crossing[k]);
    }
    if (triangle != kNoWord) {
      landings.way[brink.particle] = static_cast<float>(brink.way + crossed / voxel_);
      return triangle;
    }
    double nearest = kHalf * brink.size;
    for (std::size_t k = brink.last; k-- > first;) {
      triangle = pairs_.distance[k] <= nearest ? triangle_[k] : triangle;
      nearest = std::min(nearest, pairs_.distance[k]);
    }
    return triangle;
  }

  const Brink& brink(std::size_t b) const { return brinks_[b]; }

 private:
  void place(const Particles& particles, const Landings& landings, std::uint32_t i, std::size_t b) {
    const Vec3d o{particles.ox[i], particles.oy[i], particles.oz[i]};
    const Vec3d d{particles.dx[i], particles.dy[i], particles.dz[i]};
    const double way = landings.way[i];
    const Vec3d at = o + d * way;
    const double grow = voxelAt(field_, Vec3f(at)) / voxel_;
    const double size = grow * voxel_;
    const double low = std::max(-kAround * size, (particles.begin[i] - way) * voxel_);
    brinks_[b] = {i, way, grow, size, low, d, field_.shape.centre + at * voxel_, 0};
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

  void pair(const Brink& brink, std::size_t k) {
    const Corners t = cornersOf(block_, triangle_[k]);
    const Vec3d s = brink.point - t.a;
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
    pairs_.dx[k] = brink.d.x;
    pairs_.dy[k] = brink.d.y;
    pairs_.dz[k] = brink.d.z;
    pairs_.low[k] = brink.low;
    pairs_.high[k] = kAround * brink.size;
  }

  const Field& field_;
  const TriangleBlock& block_;
  double voxel_;
  std::size_t count_ = 0;
  std::array<Brink, kBrinksAtOnce> brinks_;
  std::uint32_t cell_[kBrinksAtOnce][kLooks.size()];  // of the looks: voxelCorner()
  alignas(64) std::uint32_t words_[kBrinksAtOnce][kWords];
  std::uint32_t triangle_[kBrinksAtOnce * kWords];  // of the pairs
  PairLanes pairs_;
};

}  // namespace

void settleBrinks(const Field& field, const TriangleBlock& triangles, const MarchOptions& options, Particles& particles,
                  std::span<const std::uint32_t> at, Landings& landings) {
  Round round(field, triangles);
  std::vector<std::uint32_t> open;
  for (const std::uint32_t i : at) {
    if (landings.outcomeOf(i) == Outcome::Brink) open.push_back(i);
  }
  while (!open.empty()) {
    std::vector<std::uint32_t> next;
    for (std::size_t first = 0; first < open.size(); first += kBrinksAtOnce) {
      const auto some =
          std::span<const std::uint32_t>(open).subspan(first, std::min(kBrinksAtOnce, open.size() - first));
      round.look(particles, landings, some);
      for (std::size_t b = 0; b < some.size(); ++b) {
        const std::uint32_t i = some[b];
        const std::uint32_t taken = landings.stepsOf(i);
        const std::uint32_t triangle = round.triangleAt(b, landings);
        if (triangle != kNoWord) {
          landings.triangle[i] = triangle;
          landings.outcome[i] = static_cast<std::uint32_t>(Outcome::Hit) + 4 * taken;
          continue;
        }
        MarchOptions rest = options;
        rest.steps = options.steps > taken ? options.steps - taken : 0;
        particles.begin[i] = static_cast<float>(round.brink(b).way + double{kBrink} * round.brink(b).grow);
        const Landing landing = marchOne(field, triangles, rest, particles, i);
        landings.way[i] = landing.way;
        landings.triangle[i] = landing.triangle;
        landings.outcome[i] = static_cast<std::uint32_t>(landing.outcome) + 4 * (landing.steps + taken);
        if (landing.outcome == Outcome::Brink) next.push_back(i);
      }
    }
    open.swap(next);
  }
}

}  // namespace scanmill
