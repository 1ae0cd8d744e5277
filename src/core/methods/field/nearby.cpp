#include "methods/field/nearby.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "methods/field/distance_field.h"
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
      : size_(std::max({std::fabs(point.x), std::fabs(point.y), std::fabs(point.z)})),
        point_{static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z), 0} {
    shrink(radius);
  }

  void shrink(double radius) {
    radius_ = static_cast<float>(radius + 1e-6 * (size_ + radius));
    square_ = radius_ * radius_;
  }
  float radius() const { return radius_; }
  Float4 point() const { return point_; }

  // Returns true if a triangle's bounding box is within the ball's radius of the cube of half side `half` around the
  // point.
  bool overlaps(const TriangleBlock& block, std::uint32_t triangle, float half = 0) const {
    const Triangle& corners = block.corners[triangle];
    const Float4 a = vertexOf(block, corners[0]);
    const Float4 b = vertexOf(block, corners[1]);
    const Float4 c = vertexOf(block, corners[2]);
    const auto lower = [](Float4 x, Float4 y) { return x < y ? x : y; };
    const auto higher = [](Float4 x, Float4 y) { return x > y ? x : y; };
    const Float4 outside = higher(lower(lower(a, b), c) - point_, point_ - higher(higher(a, b), c)) - half;
    const Float4 gaps = higher(outside, Float4{});
    return gaps[0] * gaps[0] + gaps[1] * gaps[1] + gaps[2] * gaps[2] <= square_;
  }

 private:
  double size_;
  Float4 point_;
  float radius_ = 0;
  float square_ = 0;
};

void runQuery(const World& world, const Ball& ball, RTCPointQueryFunction found, void* search) {
  RTCPointQuery query;
  query.x = ball.point()[0];
  query.y = ball.point()[1];
  query.z = ball.point()[2];
  query.time = 0;
  query.radius = ball.radius();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(world.embree.get(), &query, &context, found, search);
}

Vec3d metresOf(const BrickPlace& place, const Vec3f& point) {
  return place.centre + Vec3d(point) * place.voxel;
}

struct PointSearch {
  const TriangleBlock& block;
  const BrickPlace& place;
  const Vec3f& point;  // voxels, relative to the centre of the brick
  FacetCache& facets;
  Ball ball;
  NearestFacet best;
};

// Returns the search radius (m) for a squared distance (voxels^2), with a margin for the rounding of facets' distances.
double reachOf(const BrickPlace& place, float distance2) {
  return (double{std::sqrt(distance2)} + 1e-4) * place.voxel;
}

bool visitNearest(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<PointSearch*>(arguments->userPtr);
  const std::uint32_t triangle = search.block.indexOf(arguments->geomID, arguments->primID);
  if (!search.ball.overlaps(search.block, triangle)) return false;
  const Facet<float>& facet = search.facets.of(search.block, triangle, search.place);
  const float distance2 = facet.distance2(search.point.x, search.point.y, search.point.z);
  NearestFacet& best = search.best;
  if (distance2 > best.distance2) return false;
  if (distance2 == best.distance2) {
    if (best.triangle == kNoTriangle || orderOf(search.block, triangle) < orderOf(search.block, best.triangle)) {
      best.triangle = triangle;
    }
    return false;
  }
  best = {distance2, triangle};
  search.ball.shrink(reachOf(search.place, distance2));
  arguments->query->radius = search.ball.radius();
  return true;
}

struct Gathering {
  const TriangleBlock& block;
  Ball margin;  // ball at the cube's centre; its radius is the margin around the cube
  float half;   // m, half of the cube's side
  std::size_t most;
  std::vector<std::uint32_t>& triangles;
};

bool visitGathered(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Gathering*>(arguments->userPtr);
  if (search.triangles.size() > search.most) return false;
  const std::uint32_t triangle = search.block.indexOf(arguments->geomID, arguments->primID);
  if (!search.margin.overlaps(search.block, triangle, search.half)) return false;
  search.triangles.push_back(triangle);
  if (search.triangles.size() <= search.most) return false;
  arguments->query->radius = 0;  // a radius of 0 ends the query
  return true;
}

}  // namespace

TriangleCorners cornersAt(const TriangleBlock& block, std::uint32_t triangle, const BrickPlace& place) {
  const double perMetre = 1 / place.voxel;
  const Triangle& corners = block.corners[triangle];
  const auto corner = [&](int i) { return (Vec3d(block.vertices[corners[i]]) - place.centre) * perMetre; };
  return {corner(0), corner(1), corner(2)};
}

NearestFacet nearestFacet(const World& world, const BrickPlace& place, const Vec3f& point, const NearestFacet& nearest,
                          FacetCache& facets) {
  PointSearch search{world.baked, place, point, facets, Ball(metresOf(place, point), reachOf(place, nearest.distance2)),
                     nearest};
  runQuery(world, search.ball, visitNearest, &search);
  return search.best;
}

bool gatherTriangles(const World& world, const BrickPlace& place, const Vec3f& point, float half, float margin,
                     std::size_t most, std::vector<std::uint32_t>& triangles) {
  triangles.clear();
  const Vec3d metres = metresOf(place, point);
  Gathering search{world.baked, Ball(metres, margin * place.voxel), static_cast<float>(half * place.voxel), most,
                   triangles};
  runQuery(world, Ball(metres, (half * std::sqrt(3.0) + margin) * place.voxel), visitGathered, &search);
  return triangles.size() <= most;
}

}  // namespace scanmill
