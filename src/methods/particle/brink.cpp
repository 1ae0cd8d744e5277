// What became of particles that were near a surface and moved away again.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "methods/particle/march.h"
#include "methods/particle/march_rule.h"

namespace scanmill {

namespace {

constexpr double kHalf = 0.5;    // voxels: so near to a triangle a particle is at rest
constexpr double kAround = 1.5;  // voxels: so far from the brink it may have crossed something

struct Corners {
  Vec3d a, b, c;
};

Corners cornersOf(const TriangleBlock& block, std::uint32_t triangle) {
  const Triangle& t = block.corners[triangle];
  return {Vec3d(block.vertices[t[0]]), Vec3d(block.vertices[t[1]]), Vec3d(block.vertices[t[2]])};
}

// Where a line crosses a triangle (Moeller and Trumbore 1997); not a number where it does not.
double crossingOf(const Corners& t, const Vec3d& o, const Vec3d& d) {
  const Vec3d ab = t.b - t.a;
  const Vec3d ac = t.c - t.a;
  const Vec3d p = cross(d, ac);
  const double determinant = dot(ab, p);
  const double sign = determinant < 0 ? -1 : 1;
  const Vec3d s = o - t.a;
  const double u = dot(s, p) * sign;
  const Vec3d q = cross(s, ab);
  const double v = dot(d, q) * sign;
  const bool inside = u >= 0 && v >= 0 && u + v <= determinant * sign;
  return inside ? dot(ac, q) / determinant : std::numeric_limits<double>::quiet_NaN();
}

double toSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double along = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0);
  return length(p - (a + ab * along));
}

// Infinite where that is more than `most`: what lies so far from the plane is not looked at closely.
double distanceUpTo(double most, const Corners& t, const Vec3d& p) {
  const Vec3d normal = cross(t.b - t.a, t.c - t.a);
  const double away = dot(normal, p - t.a);
  const double square = dot(normal, normal);
  if (away * away > most * most * square) return std::numeric_limits<double>::infinity();
  if (!std::isnan(crossingOf(t, p, normal))) return std::abs(away) / std::sqrt(square);
  return std::min({toSegment(p, t.a, t.b), toSegment(p, t.b, t.c), toSegment(p, t.c, t.a)});
}

// The triangles that the field names along the last steps before and after the brink, each once.
class Named {
 public:
  Named(const Field& field, const TriangleBlock& block, const Vec3d& brink, const Vec3d& d, double grow) {
    for (const double step : {-0.8, 0.0, 0.8}) {
      for (const std::uint32_t triangle : trianglesAround(field, Vec3f(brink + d * (step * grow)))) {
        if (triangle == kNoWord || std::find(begin(), end(), triangle) != end()) continue;
        triangles_[count_++] = triangle;
        __builtin_prefetch(&block.corners[triangle]);
      }
    }
    // All of them at once: they lie anywhere in memory.
    for (const std::uint32_t triangle : *this) {
      for (const std::uint32_t corner : block.corners[triangle]) __builtin_prefetch(&block.vertices[corner]);
    }
  }
  const std::uint32_t* begin() const { return triangles_.data(); }
  const std::uint32_t* end() const { return triangles_.data() + count_; }

 private:
  std::array<std::uint32_t, 24> triangles_;
  std::size_t count_ = 0;
};

}  // namespace

void settleBrink(const Field& field, const TriangleBlock& triangles, const MarchOptions& options, Particles& particles,
                 std::size_t i, Landings& landings) {
  const double voxel = field.shape.voxel;
  const Vec3d o{particles.ox[i], particles.oy[i], particles.oz[i]};
  const Vec3d d{particles.dx[i], particles.dy[i], particles.dz[i]};
  while (landings.outcomeOf(i) == Outcome::Brink) {
    const double way = landings.way[i];
    const Vec3d brink = o + d * way;
    const double grow = voxelAt(field, Vec3f(brink)) / voxel;
    const Vec3d point = field.shape.centre + brink * voxel;  // m, the world's frame
    const std::uint32_t taken = landings.stepsOf(i);
    const Named named(field, triangles, brink, d, grow);
    double crossed = std::numeric_limits<double>::infinity();  // voxels of level 0, from the brink
    std::uint32_t triangle = 0;
    for (const std::uint32_t candidate : named) {
      const double at = crossingOf(cornersOf(triangles, candidate), point, d) / voxel;
      if (std::abs(at) <= kAround * grow && way + at >= particles.begin[i] && at < crossed) {
        crossed = at;
        triangle = candidate;
      }
    }
    double nearest = std::numeric_limits<double>::infinity();
    if (crossed == std::numeric_limits<double>::infinity()) {
      for (const std::uint32_t candidate : named) {
        const double away = distanceUpTo(kHalf * grow * voxel, cornersOf(triangles, candidate), point) / voxel;
        if (away < nearest) {
          nearest = away;
          triangle = candidate;
        }
      }
    }
    if (crossed < std::numeric_limits<double>::infinity()) {
      landings.way[i] = static_cast<float>(way + crossed);
      landings.triangle[i] = triangle;
      landings.outcome[i] = static_cast<std::uint32_t>(Outcome::Hit) + 4 * taken;
    } else if (nearest <= kHalf * grow) {
      landings.triangle[i] = triangle;
      landings.outcome[i] = static_cast<std::uint32_t>(Outcome::Hit) + 4 * taken;
    } else {
      MarchOptions rest = options;
      rest.steps = options.steps > taken ? options.steps - taken : 0;
      particles.begin[i] = static_cast<float>(way + double{kBrink} * grow);
      const Landing next = marchOne(field, triangles, rest, particles, i);
      landings.way[i] = next.way;
      landings.triangle[i] = next.triangle;
      landings.outcome[i] = static_cast<std::uint32_t>(next.outcome) + 4 * (next.steps + taken);
    }
  }
}

}  // namespace scanmill
