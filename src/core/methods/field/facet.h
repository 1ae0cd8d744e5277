#pragma once

// A triangle that is prepared for computing its distances to many nearby points quickly.

#include <algorithm>
#include <array>

#include "base/vec.h"

namespace scanmill {

// Affine functions of a point p, with unit gradients: the height of p over the triangle's plane and, for each edge, the
// distances by which p is inside of the edge, before the edge's start and past the edge's end. Their constants are
// computed in double. If p is near the triangle, the constants of the functions that determine the distance are about
// as large as |p|, even if corners are far away. Float32 therefore suffices to evaluate the functions.
template <class T>
struct Facet {
  Vec3<T> normal;
  T height;  // the height of p over the plane is normal . p + height
  struct Edge {
    Vec3<T> inward;  // unit vector in the triangle's plane, perpendicular to the edge, pointing inwards
    T inside;        // p is inside of the edge by inward . p + inside
    Vec3<T> along;   // unit vector from the edge's start to its end
    T before, past;  // p is before the start by before - along . p, and past the end by along . p + past
  };
  std::array<Edge, 3> edges;  // the first edge is the longest

  // Returns the squared distance from the point (x, y, z) to the triangle, which may be degenerate: a line or a point.
  // If the point is inside of all edges, this is the squared distance to the plane. Beyond the tips of a slim triangle
  // rounding may make a point seem to be inside of all edges; but such a point is past an end of the longest edge, and
  // therefore is treated as outside.
  T distance2(T x, T y, T z) const {
    const auto dotPoint = [=](const Vec3<T>& v) { return v.x * x + v.y * y + v.z * z; };
    const T overPlane = dotPoint(normal) + height;
    T inside[3];         // by edge: distance by which the point is inside of the edge
    T edgeDistance2[3];  // by edge: squared distance to the edge, in the plane
    T pastLongest = 0;   // distance by which the point is past an end of the longest edge
    for (int i = 0; i < 3; ++i) {
      inside[i] = dotPoint(edges[i].inward) + edges[i].inside;
      const T position = dotPoint(edges[i].along);
      const T excess = std::max(std::max(edges[i].before - position, position + edges[i].past), T(0));
      if (i == 0) pastLongest = excess;
      edgeDistance2[i] = inside[i] * inside[i] + excess * excess;
    }
    const T leastInside = std::min(std::min(inside[0], inside[1]), std::min(inside[2], -pastLongest));
    const T inPlane2 = std::min(std::min(edgeDistance2[0], edgeDistance2[1]), edgeDistance2[2]);
    return overPlane * overPlane + (leastInside >= T(0) ? T(0) : inPlane2);
  }
};

// Returns the facet of the triangle a b c, which may be degenerate.
inline Facet<double> facetOf(Vec3d a, Vec3d b, Vec3d c) {
  constexpr double kLine2 = 1e-20;  // a triangle is a line if its squared area is below this times its longest edge^4
  const auto square = [](const Vec3d& v) { return dot(v, v); };
  const double ab = square(b - a);
  const double bc = square(c - b);
  const double ca = square(a - c);
  const double longest = std::max({ab, bc, ca});
  // Rotate the corners so that the longest edge is the first.
  std::array<Vec3d, 3> corners{a, b, c};
  if (ab < longest) corners = bc >= ca ? std::array<Vec3d, 3>{b, c, a} : std::array<Vec3d, 3>{c, a, b};
  const std::array<Vec3d, 3> sides{corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
  const Vec3d product = cross(sides[0], -sides[2]);
  const double product2 = square(product);
  std::array<double, 3> scales{longest, square(sides[1]), square(sides[2])};
  for (double& scale : scales) scale = 1 / std::sqrt(scale);  // infinite if the length is 0
  const Vec3d first = longest > 0 ? sides[0] * scales[0] : Vec3d{1, 0, 0};
  Facet<double> facet;
  if (product2 > kLine2 * longest * longest) {
    facet.normal = product * (1 / std::sqrt(product2));
  } else {  // any unit vector perpendicular to the line can be the normal: use the x or y axis, whichever is less
            // parallel
    facet.normal = normalized(cross(first, std::fabs(first.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  }
  facet.height = -dot(facet.normal, corners[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    auto& edge = facet.edges[i];
    edge.along = i == 0 || !std::isfinite(scales[i]) ? first : sides[i] * scales[i];
    edge.inward = cross(facet.normal, edge.along);
    edge.inside = -dot(edge.inward, corners[i]);
    edge.before = dot(edge.along, corners[i]);
    edge.past = -dot(edge.along, corners[(i + 1) % 3]);
  }
  return facet;
}

// Tests whether a triangle intersects a cube around a point: this is the case if none of the 13 axes of Akenine-Moeller
// 2001, "Fast 3D triangle-box overlap testing", separates the two. The constants are computed in double, as for a
// facet. Float32 rounding may make the cube seem up to 1e-5 voxels larger or smaller than it is.
struct CubeTest {
  // Range of a linear function. If its value at the cube's centre is in this range, the function does not separate the
  // cube and the triangle.
  struct Range {
    float low, high;

    float excess(float value) const { return std::max(low - value, value - high); }
  };
  std::array<Range, 3> coordinates;  // ranges of the functions x, y and z
  Vec3f normal;
  Range heights;  // range of the function normal . p, where p is the cube's centre
  // The functions u * p[k + 1] + v * p[k + 2] (indices modulo 3) for each axis k and each edge.
  struct EdgeFunction {
    float u, v;
    Range range;
  };
  std::array<std::array<EdgeFunction, 3>, 3> edgeFunctions;

  // Returns the largest amount by which a function of this test is outside of its range, in the unit of the function;
  // at most zero if the cube around (x, y, z) intersects the triangle.
  float excess(float x, float y, float z) const {
    const float p[3] = {x, y, z};
    float largest = heights.excess(normal.x * x + normal.y * y + normal.z * z);
    for (int k = 0; k < 3; ++k) {
      largest = std::max(largest, coordinates[k].excess(p[k]));
      for (const EdgeFunction& f : edgeFunctions[k]) {
        largest = std::max(largest, f.range.excess(f.u * p[(k + 1) % 3] + f.v * p[(k + 2) % 3]));
      }
    }
    return largest;
  }
};

// Returns the test of a triangle with these corners against cubes of half side `halfSide` around points.
inline CubeTest cubeTestOf(const std::array<Vec3d, 3>& corners, double halfSide) {
  // Returns the range of a function that has these values at the triangle's corners. `radius`: largest difference of
  // the function between a point of a cube and the cube's centre.
  const auto rangeOf = [](std::initializer_list<double> values, double radius) {
    return CubeTest::Range{static_cast<float>(std::min(values) - radius),
                           static_cast<float>(std::max(values) + radius)};
  };
  const Vec3d& a = corners[0];
  const Vec3d& b = corners[1];
  const Vec3d& c = corners[2];
  const std::array<std::array<double, 3>, 3> points{{{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}}};
  const Vec3d normal = cross(b - a, c - a);
  CubeTest test;
  test.normal = Vec3f(normal);
  test.heights = rangeOf({dot(normal, a), dot(normal, b), dot(normal, c)},
                         halfSide * (std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z)));
  for (std::size_t k = 0; k < 3; ++k) {
    test.coordinates[k] = rangeOf({points[0][k], points[1][k], points[2][k]}, halfSide);
    const std::size_t l = (k + 1) % 3;
    const std::size_t m = (k + 2) % 3;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& begin = points[i];
      const auto& end = points[(i + 1) % 3];
      const auto& opposite = points[(i + 2) % 3];
      // This function is constant along axis k and along the edge.
      const double u = begin[m] - end[m];
      const double v = end[l] - begin[l];
      test.edgeFunctions[k][i] = {static_cast<float>(u), static_cast<float>(v),
                                  rangeOf({u * begin[l] + v * begin[m], u * opposite[l] + v * opposite[m]},
                                          halfSide * (std::fabs(u) + std::fabs(v)))};
    }
  }
  return test;
}

// Rounds the numbers of a facet to float32.
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
