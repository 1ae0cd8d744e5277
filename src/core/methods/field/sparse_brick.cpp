#include <algorithm>
#include <bit>
#include <cmath>

#include "methods/field/brick.h"

namespace scanmill {

// Makes a brick whose triangles_ are few: compares each triangle with all blocks' centres, then with the corners of the
// blocks near it.
void BrickMaker::makeSparse(const BrickFrame& frame) {
  facets_.resize(triangles_.size());
  centreDistance2_.resize(triangles_.size());
  Lanes least;
  least.fill(INFINITY);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Facet<float> facet = rounded(facetAt(world_.baked, triangles_[t], frame));
    const Points& p = brick::kBlockCentres;
    Lanes& distance2 = centreDistance2_[t];
    for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
    for (int i = 0; i < kLanes; ++i) least[i] = std::min(least[i], distance2[i]);
    facets_[t] = facet;
  }
  for (int block = 0; block < kBlock; ++block) {
    blockDistance_[block] = std::min(std::sqrt(least[block]), brick::gatheredRadius(block));
    if (blockDistance_[block] > kExactLimit + brick::kBlockRadius) continue;
    // Candidates are the triangles that may be the nearest to some corner of the block (up to kExactLimit), and the
    // triangles that some corner of the block may list.
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

// Sets the distances, nearest triangles and lists of a block's corners, by comparing each candidate with all of them.
void BrickMaker::fillBlock(const BrickFrame& frame, int block) {
  if (candidates_.empty()) return;
  const Points& p = brick::kBlockCorners[block];
  alignas(64) Lanes least;
  alignas(64) std::array<std::uint32_t, kLanes> nearest{};
  least.fill(INFINITY);
  if (lists_) listedBy_.assign((candidates_.size() + 31) / 32, {});
  for (std::uint32_t c = 0; c < candidates_.size(); ++c) {
    const Facet<float> facet = candidates_[c];
    alignas(64) Lanes distance2;
    for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
    for (int i = 0; i < kLanes; ++i) {
      const bool less = distance2[i] < least[i];  // of equally near triangles, the first candidate is used
      nearest[i] = less ? c : nearest[i];
      least[i] = less ? distance2[i] : least[i];
    }
    if (!lists_) continue;
    float least2 = INFINITY;  // squared distance of the candidate from the nearest corner
    for (int i = 0; i < kLanes; ++i) least2 = std::min(least2, distance2[i]);
    if (least2 > brick::kListRadius * brick::kListRadius) continue;
    const CubeTest cube = cubeTestOf(cornersAt(world_.baked, candidateTriangles_[c], frame), kListHalfSide);
    auto& lists = listedBy_[c / 32];
    const std::uint32_t bit = 1u << (c % 32);
    for (int i = 0; i < kLanes; ++i) lists[i] |= cube.excess(p.x[i], p.y[i], p.z[i]) <= 0 ? bit : 0u;
  }
  for (int i = 0; i < kBlock; ++i) {
    const std::uint32_t corner = brick::cornerIndex(block, i);
    distance2_[corner] = least[i];
    nearest_[corner] = candidateTriangles_[nearest[i]];
  }
  if (lists_) listBlock(block);
}

// Makes the lists of a block's corners from the bits of listedBy_, the lowest bit first.
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
