#pragma once

// Which triangles of a world are near a place: Embree's point queries.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/field/facet.h"
#include "methods/world/world.h"

namespace scanmill {

// Of a brick. Points around it are told in voxels from its centre.
struct BrickPlace {
  Vec3d centre;      // m, relative to the world's origin
  double voxel = 0;  // m
};

using TriangleCorners = std::array<Vec3d, 3>;

// In voxels from the place.
TriangleCorners cornersAt(const TriangleBlock& block, std::uint32_t triangle, const BrickPlace& place);

inline Facet<double> facetAt(const TriangleBlock& block, std::uint32_t triangle, const BrickPlace& place) {
  const TriangleCorners corners = cornersAt(block, triangle, place);
  return facetOf(corners[0], corners[1], corners[2]);
}

struct NearestTriangle {
  double distance2 = 0;  // voxels^2
  std::uint32_t triangle = 0;
};

// Of a brick's centre. The world has triangles; `guess` is one of them: the nearer it is, the shorter the search.
NearestTriangle nearestTriangle(const World& world, const BrickPlace& place, std::uint32_t guess);

constexpr std::uint32_t kNoTriangle = 0xFFFFFFFFu;

struct NearestFacet {
  float distance2 = 0;  // voxels^2, as Facet<float> has it
  std::uint32_t triangle = kNoTriangle;
};

// The facets of a brick that were last asked for.
class FacetCache {
 public:
  void startBrick() { ++brick_; }
  const Facet<float>& of(const TriangleBlock& block, std::uint32_t triangle, const BrickPlace& place) {
    if (slots_.empty()) slots_.resize(kSlots);
    Slot& slot = slots_[triangle * 0x9E3779B1u >> 22];
    if (slot.triangle != triangle || slot.brick != brick_) {
      slot = {triangle, brick_, rounded(facetAt(block, triangle, place))};
    }
    return slot.facet;
  }

 private:
  static constexpr std::size_t kSlots = 1024;
  struct Slot {
    std::uint32_t triangle = 0;
    std::uint32_t brick = 0;
    Facet<float> facet{};
  };
  std::vector<Slot> slots_;
  std::uint32_t brick_ = 0;
};

// Of a point by a brick, out of those nearer than `nearest` is, and those as near that come first; else `nearest`.
NearestFacet nearestFacet(const World& world, const BrickPlace& place, const Vec3f& point, const NearestFacet& nearest,
                          FacetCache& facets);

// All triangles that are at most `margin` from the cube that reaches `half` around a point by a brick (voxels), and
// some that are farther; a triangle may be there twice. False where they are more than `most`.
bool gatherTriangles(const World& world, const BrickPlace& place, const Vec3f& point, float half, float margin,
                     std::size_t most, std::vector<std::uint32_t>& triangles);

// Which comes first where triangles are equally near.
inline std::uint64_t orderOf(const TriangleBlock& block, std::uint32_t triangle) {
  return std::uint64_t{block.surfaceOf(triangle).instance} << 32 | triangle;
}

}  // namespace scanmill
