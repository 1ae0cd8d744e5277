#pragma once

// A triangle that is prepared for computing its distances to many nearby points quickly.

#include <algorithm>
#include <array>

#include "base/vec.h"

namespace scanmill {

// Affine functions of a point p, with unit gradients: the height of p over the triangle's plane and, for each edge, the
// distance by which p is inside of the edge, before its start and past its end. Their constants are computed in double.
// The constants that matter at p are about as large as p, however large the triangle is and however far away its
// corners are, so that float32 suffices to evaluate the functions.
template <class T>
struct Facet {
  Vec3<T> normal;
  T height;
  struct Edge {
    Vec3<T> inward;  // unit vector in the triangle's plane, perpendicular to the edge, pointing inwards
    T inside;
    Vec3<T> along;
    T before, past;
  };
  std::array<Edge, 3> edges;  // the first edge is the longest

  // Returns the squared distance from the point (x, y, z) to the triangle, which may be degenerate: a line or a point.
  // If the point is inside of all edges, this is the squared distance to the plane. Beyond the tips of a slim triangle
  // rounding may make a point seem to be inside of all edges; but such a point is past an end of the longest edge, and
  // therefore is treated as outside.
  T distance2(T x, T y, T z) const {
    const auto along = [=](const Vec3<T>& v) { return v.x * x + v.y * y + v.z * z; };
    const T up = along(normal) + height;
    T within[3];
    T square[3];
    T pastLongest = 0;
    for (int i = 0; i < 3; ++i) {
      within[i] = along(edges[i].inward) + edges[i].inside;
      const T position = along(edges[i].along);
      const T excess = std::max(std::max(edges[i].before - position, position + edges[i].past), T(0));
      if (i == 0) pastLongest = excess;
      square[i] = within[i] * within[i] + excess * excess;
    }
    const T least = std::min(std::min(within[0], within[1]), std::min(within[2], -pastLongest));
    const T side = std::min(std::min(square[0], square[1]), square[2]);
    return up * up + (least >= T(0) ? T(0) : side);
  }
};

// Returns the facet of the triangle a b c.
inline Facet<double> facetOf(Vec3d a, Vec3d b, Vec3d c) {
  const auto square = [](const Vec3d& v) { return dot(v, v); };
  const double ab = square(b - a);
  const double bc = square(c - b);
  const double ca = square(a - c);
  const double longest = std::max({ab, bc, ca});
  std::array<Vec3d, 3> corners{a, b, c};
  if (ab < longest) corners = bc >= ca ? std::array<Vec3d, 3>{b, c, a} : std::array<Vec3d, 3>{c, a, b};
  const std::array<Vec3d, 3> sides{corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
  Vec3d normal = cross(sides[0], -sides[2]);
  std::array<double, 4> scales{longest, square(sides[1]), square(sides[2]), square(normal)};
  const bool line = !(scales[3] > 1e-20 * longest * longest);
  for (double& scale : scales) scale = 1 / std::sqrt(scale);  // infinite if the length is 0
  const Vec3d first = longest > 0 ? sides[0] * scales[0] : Vec3d{1, 0, 0};
  if (line) {  // any unit vector perpendicular to the line can be the normal
    normal = normalized(cross(first, std::fabs(first.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  } else {
    normal = normal * scales[3];
  }
  Facet<double> facet;
  facet.normal = normal;
  facet.height = -dot(normal, corners[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    auto& edge = facet.edges[i];
    edge.along = i == 0 || !std::isfinite(scales[i]) ? first : sides[i] * scales[i];
    edge.inward = cross(normal, edge.along);
    edge.inside = -dot(edge.inward, corners[i]);
    edge.before = dot(edge.along, corners[i]);
    edge.past = -dot(edge.along, corners[(i + 1) % 3]);
  }
  return facet;
}

// Tests whether a triangle intersects a cube around a point: this is the case if none of the 13 axes of Akenine-Moeller
// 2001, "Fast 3D triangle-box overlap testing", separates the two. The constants are computed in double, as for a
// facet. Float32 rounding may make the cube seem up to 1e-5 larger or smaller than it is.
struct CubeTest {
  // A linear function of the point, and the range of values for which the function does not separate cube and triangle.
  struct Axis {
    float u, v, low, high;
  };
  std::array<float, 3> low, high;  // ranges of the functions x, y and z
  Vec3f normal;
  float lowest, highest;
  // The functions u * p[k + 1] + v * p[k + 2] (indices modulo 3) for each axis k and each edge.
  std::array<std::array<Axis, 3>, 3> axes;

  // Returns the largest amount by which a function of this test is outside of its range, in the unit of the function;
  // at most zero if the cube around (x, y, z) intersects the triangle.
  float excess(float x, float y, float z) const {
    const auto beyond = [](float value, float least, float most) { return std::max(least - value, value - most); };
    const float p[3] = {x, y, z};
    float worst = beyond(normal.x * x + normal.y * y + normal.z * z, lowest, highest);
    for (int k = 0; k < 3; ++k) {
      worst = std::max(worst, beyond(p[k], low[k], high[k]));
      const float along = p[(k + 1) % 3];
      const float across = p[(k + 2) % 3];
      for (const Axis& axis : axes[k]) {
        worst = std::max(worst, beyond(axis.u * along + axis.v * across, axis.low, axis.high));
      }
    }
    return worst;
  }
};

// Returns the test of a triangle with these corners against cubes of half side `half` around points.
inline CubeTest cubeTestOf(const std::array<Vec3d, 3>& corners, double half) {
  const auto list = [](const Vec3d& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  const std::array<std::array<double, 3>, 3> at{list(corners[0]), list(corners[1]), list(corners[2])};
  CubeTest test;
  for (std::size_t k = 0; k < 3; ++k) {
    test.low[k] = static_cast<float>(std::min({at[0][k], at[1][k], at[2][k]}) - half);
    test.high[k] = static_cast<float>(std::max({at[0][k], at[1][k], at[2][k]}) + half);
  }
  const Vec3d normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
  const std::array<double, 3> heights{dot(normal, corners[0]), dot(normal, corners[1]), dot(normal, corners[2])};
  const double reach = half * (std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z));
  test.normal = Vec3f(normal);
  test.lowest = static_cast<float>(std::min({heights[0], heights[1], heights[2]}) - reach);
  test.highest = static_cast<float>(std::max({heights[0], heights[1], heights[2]}) + reach);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t l = (k + 1) % 3;
    const std::size_t m = (k + 2) % 3;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& begin = at[i];
      const auto& end = at[(i + 1) % 3];
      const auto& opposite = at[(i + 2) % 3];
      const double u = begin[m] - end[m];
      const double v = end[l] - begin[l];
      const double edge = u * begin[l] + v * begin[m];
      const double tip = u * opposite[l] + v * opposite[m];
      const double around = half * (std::fabs(u) + std::fabs(v));
      test.axes[k][i] = {static_cast<float>(u), static_cast<float>(v), static_cast<float>(std::min(edge, tip) - around),
                         static_cast<float>(std::max(edge, tip) + around)};
    }
  }
  return test;
}

inline Facet<float> rounded(const Facet<double>& f) {
  Facet<float> r;
  r.normal = Vec3f(f.normal);
  r.height = static_cast<float>(f.height);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& e = f.edges[i];
    r.edges[i] = {Vec3f(e.inward), static_cast<float>(e.inside), Vec3f(e.along), static_cast<float>(e.before),
                  static_cast<float>(e.past)};
  }
  return r;
}

}  // namespace scanmill
