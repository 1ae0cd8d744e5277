#include "methods/field/nearby.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "scene/embree.h"

namespace scanmill {

namespace {

using Float4 [[gnu::vector_size(16)]] = float;

// Loads a vertex. The block's vertices are padded, so that 16 bytes can be read at each vertex.
Float4 vertexOf(const TriangleBlock& block, std::uint32_t vertex) {
  Float4 v;
  std::memcpy(&v, reinterpret_cast<const char*>(block.vertices.data()) + sizeof(Vec3f) * vertex, sizeof v);
  return v;
}

// A sphere around a point, in float32 (m, relative to the world's origin). Its radius is slightly larger than
// requested, so that rounding loses no triangle.
class Ball {
 public:
  Ball(const Vec3d& point, double radius)
      : largestCoordinate_(std::max({std::fabs(point.x), std::fabs(point.y), std::fabs(point.z)})),
        point_{static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z), 0} {
    shrink(radius);
  }

  void shrink(double radius) {
    constexpr double kRounding = 1e-6;  // relative error of float32, with a margin
    radius_ = static_cast<float>(radius + kRounding * (largestCoordinate_ + radius));
    radius2_ = radius_ * radius_;
  }
  float radius() const { return radius_; }
  Float4 point() const { return point_; }

  // Returns true if the distance from a triangle's bounding box to a cube around the ball's point is at most the ball's
  // radius. `halfSide`: half the side of the cube (m); 0 means the point itself.
  bool overlaps(const TriangleBlock& block, std::uint32_t triangle, float halfSide = 0) const {
    const Triangle& corners = block.corners[triangle];
    const Float4 a = vertexOf(block, corners[0]);
    const Float4 b = vertexOf(block, corners[1]);
    const Float4 c = vertexOf(block, corners[2]);
    const auto lower = [](Float4 x, Float4 y) { return x < y ? x : y; };
    const auto higher = [](Float4 x, Float4 y) { return x > y ? x : y; };
    const Float4 outside = higher(lower(lower(a, b), c) - point_, point_ - higher(higher(a, b), c)) - halfSide;
    const Float4 gaps = higher(outside, Float4{});
    return gaps[0] * gaps[0] + gaps[1] * gaps[1] + gaps[2] * gaps[2] <= radius2_;
  }

 private:
  double largestCoordinate_;
  Float4 point_;
  float radius_ = 0;
  float radius2_ = 0;
};

// Calls visit() for each triangle in the leaves of Embree's hierarchy that the ball touches. visit() gets `search` as
// the userPtr of its arguments.
void runQuery(const World& world, const Ball& ball, RTCPointQueryFunction visit, void* search) {
  const Float4 p = ball.point();
  RTCPointQuery query{.x = p[0], .y = p[1], .z = p[2], .time = 0, .radius = ball.radius()};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(world.embree.get(), &query, &context, visit, search);
}

// Converts a point from the brick's frame to metres relative to the world's origin.
Vec3d metresOf(const BrickFrame& frame, const Vec3f& point) {
  return frame.centre + Vec3d(point) * frame.voxel;
}

// The arguments and the result of a search by nearestFacet().
struct PointSearch {
  const TriangleBlock& block;
  const BrickFrame& frame;
  const Vec3f& point;  // voxels, relative to the centre of the brick
  FacetCache& facets;
  Ball ball;
  NearestFacet nearest;  // nearest triangle found so far
};

// Returns the search radius (m) for a squared distance (voxels^2), with a margin for the rounding of facets' distances.
double reachOf(const BrickFrame& frame, float distance2) {
  constexpr double kReachMargin = 1e-4;  // voxels
  return (double{std::sqrt(distance2)} + kReachMargin) * frame.voxel;
}

// Makes a triangle the result of a PointSearch if it is nearer than the result so far or, at the same distance, earlier
// by orderOf(). Returns true if the query's radius has changed.
bool visitNearest(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<PointSearch*>(arguments->userPtr);
  const std::uint32_t triangle = search.block.indexOf(arguments->geomID, arguments->primID);
  if (!search.ball.overlaps(search.block, triangle)) return false;
  const Facet<float>& facet = search.facets.facetOf(search.block, triangle, search.frame);
  const float distance2 = facet.distance2(search.point.x, search.point.y, search.point.z);
  NearestFacet& nearest = search.nearest;
  if (distance2 > nearest.distance2) return false;
  if (distance2 == nearest.distance2) {
    if (nearest.triangle == kNoTriangle || orderOf(search.block, triangle) < orderOf(search.block, nearest.triangle)) {
      nearest.triangle = triangle;
    }
    return false;
  }
  nearest = {distance2, triangle};
  search.ball.shrink(reachOf(search.frame, distance2));
  arguments->query->radius = search.ball.radius();
  return true;
}

// The arguments and the result of a search by gatherTriangles().
struct Gathering {
  const TriangleBlock& block;
  Ball margin;     // ball at the cube's centre; its radius is the margin around the cube
  float halfSide;  // m, half of the cube's side
  std::size_t mostTriangles;
  std::vector<std::uint32_t>& triangles;
};

// Adds a triangle to a Gathering if it may be within the margin. Returns true if the query's radius has changed.
bool visitGathered(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Gathering*>(arguments->userPtr);
  if (search.triangles.size() > search.mostTriangles) return false;
  const std::uint32_t triangle = search.block.indexOf(arguments->geomID, arguments->primID);
  if (!search.margin.overlaps(search.block, triangle, search.halfSide)) return false;
  search.triangles.push_back(triangle);
  if (search.triangles.size() <= search.mostTriangles) return false;
  arguments->query->radius = 0;  // a radius of 0 ends the query
  return true;
}

}  // namespace

TriangleCorners cornersAt(const TriangleBlock& block, std::uint32_t triangle, const BrickFrame& frame) {
  const double perMetre = 1 / frame.voxel;
  const Triangle& corners = block.corners[triangle];
  const auto corner = [&](int i) { return (Vec3d(block.vertices[corners[i]]) - frame.centre) * perMetre; };
  return {corner(0), corner(1), corner(2)};
}

NearestFacet nearestFacet(const World& world, const BrickFrame& frame, const Vec3f& point, const NearestFacet& guess,
                          FacetCache& facets) {
  PointSearch search{world.baked, frame, point, facets, Ball(metresOf(frame, point), reachOf(frame, guess.distance2)),
                     guess};
  runQuery(world, search.ball, visitNearest, &search);
  return search.nearest;
}

bool gatherTriangles(const World& world, const BrickFrame& frame, const Vec3f& point, float halfSide, float margin,
                     std::size_t mostTriangles, std::vector<std::uint32_t>& triangles) {
  triangles.clear();
  const Vec3d metres = metresOf(frame, point);
  Gathering search{world.baked, Ball(metres, margin * frame.voxel), static_cast<float>(halfSide * frame.voxel),
                   mostTriangles, triangles};
  runQuery(world, Ball(metres, (halfSide * std::sqrt(3.0) + margin) * frame.voxel), visitGathered, &search);
  return triangles.size() <= mostTriangles;
}

}  // namespace scanmill
