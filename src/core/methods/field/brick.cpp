#include "methods/field/brick.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace scanmill {

namespace brick {

constexpr std::array<BrickMaker::Points, BrickMaker::kBlock> kBlockCorners = [] {
  std::array<BrickMaker::Points, BrickMaker::kBlock> corners{};
  for (int block = 0; block < BrickMaker::kBlock; ++block) {
    for (int lane = 0; lane < BrickMaker::kLanes; ++lane) {
      const std::uint32_t corner = cornerIndex(block, std::min(lane, BrickMaker::kBlock - 1));
      const auto coordinate = [](std::uint32_t i) { return static_cast<float>(i % kBrickCorners) - kHalfBrick; };
      corners[block].x[lane] = coordinate(corner);
      corners[block].y[lane] = coordinate(corner / kBrickCorners);
      corners[block].z[lane] = coordinate(corner / (kBrickCorners * kBrickCorners));
    }
  }
  return corners;
}();

constexpr BrickMaker::Points kBlockCentres = [] {
  constexpr int kMiddle = BrickMaker::kBlock / 2;  // the corner in the middle of a block
  BrickMaker::Points centres{};
  for (int lane = 0; lane < BrickMaker::kLanes; ++lane) {
    const BrickMaker::Points& corners = kBlockCorners[std::min(lane, BrickMaker::kBlock - 1)];
    centres.x[lane] = corners.x[kMiddle];
    centres.y[lane] = corners.y[kMiddle];
    centres.z[lane] = corners.z[kMiddle];
  }
  return centres;
}();

}  // namespace brick

namespace {

// Number of triangles near a brick above which makeDense() is faster than makeSparse(); measured in the scene "street".
constexpr std::size_t kMostSparse = 128;

}  // namespace

void BrickMaker::make(const BrickFrame& frame, std::uint16_t* distance, std::uint32_t* triangleOrList,
                      std::vector<std::uint32_t>& listEntries) {
  listed_.clear();
  listBegin_ = 0;
  distance2_.fill(INFINITY);
  list_.fill(kNoTriangle);
  constexpr float kGathered = brick::kGatherRadius + 0.01f;  // with a margin for rounding
  if (gatherTriangles(world_, frame, {}, 0, kGathered, kMostSparse, triangles_)) {
    sortTriangles();
    makeSparse(frame);
  } else {
    makeDense(frame);
  }
  fillDistances(distance);
  const auto farthest = static_cast<std::uint16_t>((lists_ ? kListLimit : kNearestLimit) / kDistanceStep);
  const auto& entries = lists_ ? list_ : nearest_;
  for (int corner = 0; corner < kCornersPerBrick; ++corner) {
    triangleOrList[corner] = distance[corner] > farthest ? kNoTriangle : entries[corner];
  }
  if (lists_) appendLists(triangleOrList, listEntries);
  distance[kCornersPerBrick] = 0;
  triangleOrList[kCornersPerBrick] = kNoTriangle;
}

// Sorts triangles_ by orderOf(), and removes repetitions: Embree's hierarchy may have a triangle in several leaves.
void BrickMaker::sortTriangles() {
  order_.clear();
  for (const std::uint32_t t : triangles_) order_.push_back(orderOf(world_.baked, t));
  std::sort(order_.begin(), order_.end());
  order_.erase(std::unique(order_.begin(), order_.end()), order_.end());
  triangles_.clear();
  for (const std::uint64_t order : order_) triangles_.push_back(static_cast<std::uint32_t>(order));
}

// Sets the stored distances of the corners, from distance2_ and blockDistance_.
void BrickMaker::fillDistances(std::uint16_t* distance) const {
  for (int block = 0; block < kBlock; ++block) {
    const Points& p = brick::kBlockCorners[block];
    const Points& centres = brick::kBlockCentres;
    std::array<std::uint16_t, kLanes> steps;  // distances in units of kDistanceStep
    std::array<float, kLanes> exact2;         // squared distances of the corners, by lane
    for (int i = 0; i < kLanes; ++i) exact2[i] = distance2_[brick::cornerIndex(block, std::min(i, kBlock - 1))];
    for (int i = 0; i < kLanes; ++i) {
      const float x = p.x[i] - centres.x[block];
      const float y = p.y[i] - centres.y[block];
      const float z = p.z[i] - centres.z[block];
      // For distances of more than kExactLimit, use a lower bound that follows from the distance of the block's centre.
      const float bound =
          std::max(blockDistance_[block] - std::sqrt(x * x + y * y + z * z) - brick::kRounding, kExactLimit);
      const float exact = std::sqrt(exact2[i]);
      const float stored = exact <= kExactLimit ? std::max(exact - brick::kRounding, 0.0f) : bound;
      steps[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(stored * (1 / kDistanceStep)));
    }
    for (int i = 0; i < kBlock; ++i) distance[brick::cornerIndex(block, i)] = steps[i];
  }
}

// Ends the list under construction, which becomes the list of `corner`.
void BrickMaker::endList(std::uint32_t corner) {
  list_[corner] = static_cast<std::uint32_t>(listBegin_);
  listed_.back() |= kLastOfList;
  listBegin_ = listed_.size();
}

// Appends the corners' lists to `listEntries`, in the order of corners. In `triangleOrList`, replaces each list's start
// in listed_ by the list's start among the appended entries.
void BrickMaker::appendLists(std::uint32_t* triangleOrList, std::vector<std::uint32_t>& listEntries) {
  const std::size_t firstEntry = listEntries.size();
  for (int corner = 0; corner < kCornersPerBrick; ++corner) {
    if (triangleOrList[corner] == kNoTriangle) continue;
    const std::uint32_t* entry = &listed_[triangleOrList[corner]];
    triangleOrList[corner] = static_cast<std::uint32_t>(listEntries.size() - firstEntry);
    do {
      listEntries.push_back(*entry);
    } while (*entry++ < kLastOfList);
  }
}

// Makes a brick with few triangles: compares each triangle with all blocks' centres, then with near blocks' corners.
void BrickMaker::makeSparse(const BrickFrame& frame) {
  facets_.resize(triangles_.size());
  centreDistance2_.resize(triangles_.size());
  Lanes nearest2;  // by block (a lane is a block here): squared distance of the triangle nearest to its centre
  nearest2.fill(INFINITY);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Facet<float> facet = rounded(facetAt(world_.baked, triangles_[t], frame));
    const Points& p = brick::kBlockCentres;
    Lanes& distance2 = centreDistance2_[t];
    for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
    for (int i = 0; i < kLanes; ++i) nearest2[i] = std::min(nearest2[i], distance2[i]);
    facets_[t] = facet;
  }
  for (int block = 0; block < kBlock; ++block) {
    blockDistance_[block] = std::min(std::sqrt(nearest2[block]), brick::gatheredRadius(block));
    if (blockDistance_[block] > kExactLimit + brick::kBlockRadius) continue;  // fillDistances() uses the lower bound
    // Candidates are the triangles that may be the nearest to some corner of the block (up to kExactLimit), and the
    // triangles that some corner of the block may list. A corner is at most kBlockRadius from the centre, so its
    // nearest triangle is at most blockDistance_ + kBlockRadius from the corner and kBlockRadius more from the centre.
    float reach = std::min(blockDistance_[block] + 2 * brick::kBlockRadius, kExactLimit + brick::kBlockRadius);
    if (lists_) reach = std::max(reach, brick::kListRadius + brick::kBlockRadius);
    candidates_.clear();
    candidateTriangles_.clear();
    for (std::size_t t = 0; t < facets_.size(); ++t) {
      if (centreDistance2_[t][block] > reach * reach) continue;
      candidates_.push_back(facets_[t]);
      candidateTriangles_.push_back(triangles_[t]);
    }
    fillBlock(frame, block);
  }
}

// Sets the distances, nearest triangles and lists of a block's corners: compares each candidate with all these corners.
void BrickMaker::fillBlock(const BrickFrame& frame, int block) {
  if (candidates_.empty()) return;
  const Points& p = brick::kBlockCorners[block];
  // The candidate nearest to each lane's corner, and its squared distance.
  alignas(64) std::array<std::uint32_t, kLanes> nearest{};
  alignas(64) Lanes nearest2;
  nearest2.fill(INFINITY);
  if (lists_) listedBy_.assign((candidates_.size() + 31) / 32, {});
  for (std::uint32_t c = 0; c < candidates_.size(); ++c) {
    const Facet<float> facet = candidates_[c];
    alignas(64) Lanes distance2;
    for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
    for (int i = 0; i < kLanes; ++i) {
      const bool isNearer = distance2[i] < nearest2[i];  // of equally near triangles, the first candidate is used
      nearest[i] = isNearer ? c : nearest[i];
      nearest2[i] = isNearer ? distance2[i] : nearest2[i];
    }
    if (!lists_) continue;
    float least2 = INFINITY;  // squared distance from the candidate to the corner nearest to it
    for (int i = 0; i < kLanes; ++i) least2 = std::min(least2, distance2[i]);
    if (least2 > brick::kListRadius * brick::kListRadius) continue;
    const CubeTest cube = cubeTestOf(cornersAt(world_.baked, candidateTriangles_[c], frame), kListHalfSide);
    auto& lists = listedBy_[c / 32];
    const std::uint32_t bit = 1u << (c % 32);
    for (int i = 0; i < kLanes; ++i) lists[i] |= cube.excess(p.x[i], p.y[i], p.z[i]) <= 0 ? bit : 0u;
  }
  for (int i = 0; i < kBlock; ++i) {
    const std::uint32_t corner = brick::cornerIndex(block, i);
    distance2_[corner] = nearest2[i];
    nearest_[corner] = candidateTriangles_[nearest[i]];
  }
  if (lists_) listBlock(block);
}

// Makes the lists of a block's corners from the bits of listedBy_, from the lowest bit to the highest.
void BrickMaker::listBlock(int block) {
  for (int i = 0; i < kBlock; ++i) {
    for (std::size_t word = 0; word < listedBy_.size(); ++word) {
      for (std::uint32_t bits = listedBy_[word][i]; bits != 0; bits &= bits - 1) {
        listed_.push_back(candidateTriangles_[word * 32 + std::countr_zero(bits)]);
      }
    }
    if (listed_.size() > listBegin_) endList(brick::cornerIndex(block, i));
  }
}

}  // namespace scanmill
