#pragma once

// The distances and the triangles that the corners of one brick keep.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/field/facet.h"
#include "methods/field/nearby.h"
#include "methods/world/world.h"

namespace scanmill {

// Makes bricks, one after the other, and keeps its buffers from one to the next. What a brick holds follows from its
// place alone.
//
// There are several ways to the same bytes. Where few triangles are near a brick, or near a block of it, each triangle
// is compared with all corners there. Among leaves, where a block may have thousands, each triangle is compared only
// with the few corners that list it, and the other corners search for their nearest triangle: the street is built
// in 1.3 to 2 s so, and else in 12 to 25.
class BrickMaker {
 public:
  BrickMaker(const World& world, bool lists) : world_(world), lists_(lists) {}

  // Fills kBrickStride distances and words (see DistanceField) of the full brick at `place`. With lists, they are
  // appended to `entries`, and words count from there.
  void make(const BrickPlace& place, std::uint16_t* distance, std::uint32_t* word, std::vector<std::uint32_t>& entries);

  // The corners are looked at in 27 blocks of 3 x 3 x 3, as lanes; the lanes left over repeat the last corner.
  static constexpr int kBlock = 27;
  static constexpr int kLanes = 32;
  using Lanes = std::array<float, kLanes>;
  struct alignas(64) Points {
    Lanes x, y, z;
  };

 private:
  struct Listing {
    std::uint32_t corner, triangle;
  };

  // In brick.cpp.
  void sortTriangles();
  void addList(std::uint32_t corner);
  void fillWords(const std::uint16_t* distance, std::uint32_t* word) const;
  void placeLists(std::uint32_t* word, std::vector<std::uint32_t>& entries);
  void fillDistances(std::uint16_t* distance) const;

  // In sparse_brick.cpp.
  void makeSparse(const BrickPlace& place);
  void fillBlock(const BrickPlace& place, int block);
  void listBlock(int block);

  // In dense_brick.cpp.
  void makeDense(const BrickPlace& place);
  bool makeBlock(const BrickPlace& place, int block);
  void searchBlock(const BrickPlace& place, int block);
  void scatter(const BrickPlace& place, std::uint32_t triangle);
  void sortListings();
  NearestFacet search(const BrickPlace& place, const Vec3f& point, float reach);

  const World& world_;
  bool lists_;
  std::vector<std::uint32_t> triangles_;  // near the brick or the block, in the order of lists
  std::vector<std::uint64_t> order_;

  // Of corners: the nearest triangle, and where the list begins in listed_; infinite and kNoWord where unknown or too
  // far.
  std::array<float, kBrickStride> distance2_{};
  std::array<std::uint32_t, kBrickStride> nearest_{};
  std::array<std::uint32_t, kBrickStride> list_{};
  std::array<float, kBlock> blockDistance_{};  // from blocks' centres, not too large

  // Of a block: what is held against its corners, in the order of lists.
  std::vector<Facet<float>> candidates_;
  std::vector<std::uint32_t> candidateTriangles_;
  std::vector<std::array<std::uint32_t, kLanes>> listedBy_;  // bit i of [c]: by candidate 32 c + i

  // Of sparse bricks.
  std::vector<Facet<float>> facets_;    // of triangles_
  std::vector<Lanes> centreDistance2_;  // of facets_ from the blocks' centres

  // Of dense bricks.
  FacetCache cache_;
  std::uint32_t guess_ = kNoTriangle;      // of the nearest triangle
  std::vector<int> crowded_;               // blocks with too many candidates
  std::array<bool, kBrickStride> open_{};  // corners of crowded blocks
  std::vector<Listing> listings_;
  std::vector<std::uint32_t> listingsByCorner_;

  std::vector<std::uint32_t> listed_;
  std::size_t listBegin_ = 0;  // in listed_, of the list under construction
};

// Shared by the parts of BrickMaker; lengths in voxels.
namespace brick {

// Distances computed in float32 err by up to 1e-5. They are shortened by this much, so that they are never too large.
constexpr float kRounding = 2e-5f;
constexpr float kShortened = 1 - 1e-5f;   // and distances of bricks' centres to this share
constexpr float kRadius = 6.93f;          // a little more than 4 sqrt(3), from a brick's centre to its corners
constexpr float kListedRadius = 0.9536f;  // a little more than sqrt(3) kListedHalf: of a ball that holds the cube
constexpr float kBlockRadius = 1.7322f;   // a little more than sqrt(3), from a block's centre to its corners
static_assert(kListedRadius * kListedRadius > 3 * kListedHalf * kListedHalf);
// All triangles within kExact of a corner of the brick lie within this distance of the brick's centre.
constexpr float kSeen = kRadius + kExact;

// Corners relative to the brick's centre, by block.
extern const std::array<BrickMaker::Points, BrickMaker::kBlock> kBlockCorners;
extern const BrickMaker::Points kBlockCentres;

// Index of a block's corner among the brick's.
constexpr std::uint32_t cornerIndex(int block, int lane) {
  const auto axis = [](int b, int i) { return static_cast<std::uint32_t>(b * 3 + i); };
  return (axis(block / 9, lane / 9) * kBrickCorners + axis(block / 3 % 3, lane / 3 % 3)) * kBrickCorners +
         axis(block % 3, lane % 3);
}

// How far from a block's centre triangles are known.
inline float seenFrom(int block) {
  const auto& c = kBlockCentres;
  return kSeen - std::sqrt(c.x[block] * c.x[block] + c.y[block] * c.y[block] + c.z[block] * c.z[block]);
}

}  // namespace brick

}  // namespace scanmill
