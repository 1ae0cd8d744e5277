#pragma once

// Finds the triangles of a world near a point, with Embree's point queries.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/field/facet.h"
#include "methods/world/world.h"

namespace scanmill {

// The frame of a brick: points are in voxels, relative to the brick's centre.
struct BrickFrame {
  Vec3d centre;      // m, relative to the world's origin
  double voxel = 0;  // m, side of a voxel
};

using TriangleCorners = std::array<Vec3d, 3>;

// Returns the corners of a triangle in voxels, relative to the brick's centre.
TriangleCorners cornersAt(const TriangleBlock& block, std::uint32_t triangle, const BrickFrame& frame);

inline Facet<double> facetAt(const TriangleBlock& block, std::uint32_t triangle, const BrickFrame& frame) {
  const TriangleCorners corners = cornersAt(block, triangle, frame);
  return facetOf(corners[0], corners[1], corners[2]);
}

struct NearestFacet {
  float distance2 = 0;  // voxels^2, from the point, computed by Facet<float>::distance2()
  std::uint32_t triangle = kNoTriangle;
};

// Caches facets of recently used triangles in the frame of the current brick. startBrick() invalidates all of them.
class FacetCache {
 public:
  void startBrick() { ++brick_; }
  const Facet<float>& facetOf(const TriangleBlock& block, std::uint32_t triangle, const BrickFrame& frame) {
    if (slots_.empty()) slots_.resize(kSlots);
    Slot& slot = slots_[triangle * 0x9E3779B1u >> 22];  // a multiplicative hash, of which 10 bits are used
    if (slot.triangle != triangle || slot.brick != brick_) {
      slot = {triangle, brick_, rounded(facetAt(block, triangle, frame))};
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

// Returns the triangle nearest to `point` (in the brick's frame). The result is `guess` if no other triangle is nearer,
// or equally near with a lower orderOf().
NearestFacet nearestFacet(const World& world, const BrickFrame& frame, const Vec3f& point, const NearestFacet& guess,
                          FacetCache& facets);

// Sets `triangles` to all triangles that are at most `margin` away from the cube of half side `halfSide` around a point
// (frame of the brick), and possibly some that are farther away (all lengths in voxels). A triangle may be listed
// several times. If there are more than `mostTriangles` entries, returns false and an incomplete list.
bool gatherTriangles(const World& world, const BrickFrame& frame, const Vec3f& point, float halfSide, float margin,
                     std::size_t mostTriangles, std::vector<std::uint32_t>& triangles);

// Returns the rank of a triangle: of equally near triangles, the one with the lowest rank counts as the nearest. The
// low 32 bits of the rank are the triangle's index.
inline std::uint64_t orderOf(const TriangleBlock& block, std::uint32_t triangle) {
  return std::uint64_t{block.surfaceOf(triangle).instance} << 32 | triangle;
}

}  // namespace scanmill
