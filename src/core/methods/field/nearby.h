#pragma once

// Finds the triangles of a world near a point, with Embree's point queries.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/field/facet.h"
#include "methods/world/world.h"

namespace scanmill {

// The position of a brick. Points near the brick are given in voxels, relative to its centre.
struct BrickPlace {
  Vec3d centre;      // m, relative to the world's origin
  double voxel = 0;  // m, side of a voxel
};

using TriangleCorners = std::array<Vec3d, 3>;

// Returns the corners of a triangle in voxels, relative to the brick's centre.
TriangleCorners cornersAt(const TriangleBlock& block, std::uint32_t triangle, const BrickPlace& place);

inline Facet<double> facetAt(const TriangleBlock& block, std::uint32_t triangle, const BrickPlace& place) {
  const TriangleCorners corners = cornersAt(block, triangle, place);
  return facetOf(corners[0], corners[1], corners[2]);
}

constexpr std::uint32_t kNoTriangle = 0xFFFFFFFFu;

struct NearestFacet {
  float distance2 = 0;  // voxels^2, computed by Facet<float>::distance2()
  std::uint32_t triangle = kNoTriangle;
};

// Caches the facets of recently used triangles in the frame of the current brick.
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

// Returns the triangle nearest to a point near a brick. This is `nearest`, unless another triangle is nearer, or is
// equally near and has a lower orderOf().
NearestFacet nearestFacet(const World& world, const BrickPlace& place, const Vec3f& point, const NearestFacet& nearest,
                          FacetCache& facets);

// Sets `triangles` to all triangles that are at most `margin` away from the cube of half side `half` around a point
// near a brick, and possibly some that are farther away (all lengths in voxels). A triangle may be listed several
// times. If there are more than `most` entries, returns false and an incomplete list.
bool gatherTriangles(const World& world, const BrickPlace& place, const Vec3f& point, float half, float margin,
                     std::size_t most, std::vector<std::uint32_t>& triangles);

// Returns the rank of a triangle: of equally near triangles, the one with the lowest rank counts as the nearest.
inline std::uint64_t orderOf(const TriangleBlock& block, std::uint32_t triangle) {
  return std::uint64_t{block.surfaceOf(triangle).instance} << 32 | triangle;
}

}  // namespace scanmill
