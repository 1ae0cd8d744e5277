#pragma once

// Computes the distances and triangles that a brick stores for its corners.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/field/facet.h"
#include "methods/field/nearby.h"
#include "methods/world/world.h"

namespace scanmill {

// Makes bricks one after the other, and reuses its buffers. The content of a brick depends only on its position.
//
// Several algorithms give the same bytes. If few triangles are near a brick or a block, each triangle is compared with
// all corners of this brick or block. In foliage, where a block may have thousands of triangles, each triangle is
// compared only with the few corners that list the triangle, and other corners search for their nearest triangle. The
// choice of the algorithm reduces the time of building the field in the scene "street" from 12-25 s to 1.3-2 s.
class BrickMaker {
 public:
  BrickMaker(const World& world, bool lists) : world_(world), lists_(lists) {}

  // Sets the kBrickStride elements of `distance` and of `triangleOrList` (see DistanceField) for a full brick. In a
  // field with lists, appends the lists' entries to `listEntries`; the starts of the lists in `triangleOrList` then
  // count from the first appended entry.
  void make(const BrickFrame& frame, std::uint16_t* distance, std::uint32_t* triangleOrList,
            std::vector<std::uint32_t>& listEntries);

  // Corners are processed in 27 blocks of 3 x 3 x 3; a lane has one corner. Surplus lanes repeat the last corner.
  static constexpr int kBlock = 27;
  static constexpr int kLanes = 32;
  using Lanes = std::array<float, kLanes>;
  struct alignas(64) Points {
    Lanes x, y, z;
  };

 private:
  // An entry of a corner's list.
  struct Listing {
    std::uint32_t corner, triangle;
  };

  void sortTriangles();
  void endList(std::uint32_t corner);
  void appendLists(std::uint32_t* triangleOrList, std::vector<std::uint32_t>& listEntries);
  void fillDistances(std::uint16_t* distance) const;
  void makeSparse(const BrickFrame& frame);
  void fillBlock(const BrickFrame& frame, int block);
  void listBlock(int block);

  // Defined in dense_brick.cpp:
  void makeDense(const BrickFrame& frame);
  [[nodiscard]] bool makeBlock(const BrickFrame& frame, int block);
  void searchBlock(const BrickFrame& frame, int block);
  void addListings(const BrickFrame& frame, std::uint32_t triangle);
  void sortListings();
  NearestFacet search(const BrickFrame& frame, const Vec3f& point, float reach);

  const World& world_;
  bool lists_;
  std::vector<std::uint32_t> triangles_;  // triangles near the brick or the block, in the order of DistanceField::lists
  std::vector<std::uint64_t> order_;      // buffer of sortTriangles()

  // Arrays by corner: squared distance to the nearest triangle (voxels^2), that triangle, and the start of the corner's
  // list in listed_. If no triangle is known, the distance is infinite and the triangle undefined; if the corner has no
  // list, the start is kNoTriangle.
  std::array<float, kBrickStride> distance2_{};
  std::array<std::uint32_t, kBrickStride> nearest_{};
  std::array<std::uint32_t, kBrickStride> list_{};
  std::array<float, kBlock> blockDistance_{};  // voxels, lower bound of each block centre's distance to triangles

  // The triangles that are compared with the corners of the current block, in the order of DistanceField::lists.
  std::vector<Facet<float>> candidates_;
  std::vector<std::uint32_t> candidateTriangles_;
  std::vector<std::array<std::uint32_t, kLanes>> listedBy_;  // bit i of [c][lane] is set if the lane's corner lists
                                                             // candidate 32 c + i

  // Buffers for sparse bricks.
  std::vector<Facet<float>> facets_;    // facets of triangles_
  std::vector<Lanes> centreDistance2_;  // squared distances (voxels^2) from each facet to the blocks' centres

  // Buffers for dense bricks.
  FacetCache cache_;
  std::uint32_t guess_ = kNoTriangle;           // triangle found by the last search; the next search begins with it
  std::vector<int> crowded_;                    // blocks with too many candidates
  std::array<bool, kBrickStride> isCrowded_{};  // true for the corners of crowded blocks
  std::vector<Listing> listings_;
  std::vector<std::uint32_t> listingsByCorner_;  // triangles of listings_, corner by corner

  std::vector<std::uint32_t> listed_;  // triangles of all lists, one list after the other
  std::size_t listBegin_ = 0;          // start in listed_ of the list under construction
};

// Constants and functions that the parts of BrickMaker share; lengths are in voxels.
namespace brick {

// Twice the largest float32 error of distances (voxels). Stored distances are less by this, so none is too large.
constexpr float kRounding = 2e-5f;
constexpr float kShortened = 1 - 1e-5f;  // factor on distances of bricks' centres, so that they are never too large
constexpr float kRadius = 6.93f;         // distance from a brick's centre to its corners, rounded up: 4 sqrt(3)
constexpr float kListRadius = 0.9536f;   // radius of a ball that contains a cube of side 2 kListHalfSide: slightly more
                                         // than sqrt(3) kListHalfSide
constexpr float kBlockRadius = 1.7322f;  // distance from a block's centre to its corners, rounded up: sqrt(3)
static_assert(kListRadius * kListRadius > 3 * kListHalfSide * kListHalfSide);
// A triangle at most kExactLimit from a corner of the brick is at most kGatherRadius from the brick's centre.
constexpr float kGatherRadius = kRadius + kExactLimit;

// Positions relative to the brick's centre: the corners of each block, by lane, and the centres of the blocks.
extern const std::array<BrickMaker::Points, BrickMaker::kBlock> kBlockCorners;
extern const BrickMaker::Points kBlockCentres;

// Returns the index of a block's corner among the brick's corners. Blocks, and the corners of a block, are numbered as
// the brick's corners: x runs fastest, then y, then z.
constexpr std::uint32_t cornerIndex(int block, int lane) {
  const auto coordinate = [](int ofBlock, int inBlock) { return static_cast<std::uint32_t>(ofBlock * 3 + inBlock); };
  return (coordinate(block / 9, lane / 9) * kBrickCorners + coordinate(block / 3 % 3, lane / 3 % 3)) * kBrickCorners +
         coordinate(block % 3, lane % 3);
}

// Returns the distance (voxels) from a block's centre up to which all triangles have been gathered. Triangles are
// gathered up to kGatherRadius from the brick's centre.
inline float gatheredRadius(int block) {
  const auto& c = kBlockCentres;
  return kGatherRadius - std::sqrt(c.x[block] * c.x[block] + c.y[block] * c.y[block] + c.z[block] * c.z[block]);
}

}  // namespace brick

}  // namespace scanmill
