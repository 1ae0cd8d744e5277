#include "methods/field/brick.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace brick {

namespace {

constexpr std::array<BrickMaker::Points, BrickMaker::kBlock> blockCorners() {
  std::array<BrickMaker::Points, BrickMaker::kBlock> made{};
  for (int block = 0; block < BrickMaker::kBlock; ++block) {
    for (int lane = 0; lane < BrickMaker::kLanes; ++lane) {
      const std::uint32_t corner = cornerIndex(block, std::min(lane, BrickMaker::kBlock - 1));
      const auto place = [](std::uint32_t i) { return static_cast<float>(i % kBrickCorners) - kHalfBrick; };
      made[block].x[lane] = place(corner);
      made[block].y[lane] = place(corner / kBrickCorners);
      made[block].z[lane] = place(corner / (kBrickCorners * kBrickCorners));
    }
  }
  return made;
}

constexpr BrickMaker::Points blockCentres() {
  constexpr int kMiddle = BrickMaker::kBlock / 2;
  const auto corners = blockCorners();
  BrickMaker::Points made{};
  for (int lane = 0; lane < BrickMaker::kLanes; ++lane) {
    const BrickMaker::Points& block = corners[std::min(lane, BrickMaker::kBlock - 1)];
    made.x[lane] = block.x[kMiddle];
    made.y[lane] = block.y[kMiddle];
    made.z[lane] = block.z[kMiddle];
  }
  return made;
}

}  // namespace

constexpr std::array<BrickMaker::Points, BrickMaker::kBlock> kBlockCorners = blockCorners();
constexpr BrickMaker::Points kBlockCentres = blockCentres();

}  // namespace brick

namespace {

// Number of triangles near a brick above which makeDense() is faster than makeSparse(); measured in the scene "street".
constexpr std::size_t kMostSparse = 128;

}  // namespace

void BrickMaker::make(const BrickPlace& place, std::uint16_t* distance, std::uint32_t* word,
                      std::vector<std::uint32_t>& entries) {
  listed_.clear();
  listBegin_ = 0;
  distance2_.fill(INFINITY);
  list_.fill(kNoWord);
  constexpr float kGathered = brick::kGatherRadius + 0.01f;
  if (gatherTriangles(world_, place, {}, 0, kGathered, kMostSparse, triangles_)) {
    sortTriangles();
    makeSparse(place);
  } else {
    makeDense(place);
  }
  fillDistances(distance);
  fillWords(distance, word);
  if (lists_) placeLists(word, entries);
  distance[kCornersPerBrick] = 0;
  word[kCornersPerBrick] = kNoWord;
}

void BrickMaker::sortTriangles() {
  order_.clear();
  for (const std::uint32_t t : triangles_) order_.push_back(orderOf(world_.baked, t));
  std::sort(order_.begin(), order_.end());
  // Embree's hierarchy may have a triangle in several leaves, so a triangle may be found several times.
  order_.erase(std::unique(order_.begin(), order_.end()), order_.end());
  triangles_.clear();
  for (const std::uint64_t key : order_) triangles_.push_back(static_cast<std::uint32_t>(key));
}

void BrickMaker::fillDistances(std::uint16_t* distance) const {
  for (int block = 0; block < kBlock; ++block) {
    const Points& p = brick::kBlockCorners[block];
    const Points& centres = brick::kBlockCentres;
    std::array<std::uint16_t, kLanes> steps;
    std::array<float, kLanes> exact;
    for (int i = 0; i < kLanes; ++i) exact[i] = distance2_[brick::cornerIndex(block, std::min(i, kBlock - 1))];
    for (int i = 0; i < kLanes; ++i) {
      const float x = p.x[i] - centres.x[block];
      const float y = p.y[i] - centres.y[block];
      const float z = p.z[i] - centres.z[block];
      // If the exact distance is more than kExactLimit, use a lower bound that follows from the distance of the block's
      // centre.
      const float bound =
          std::max(blockDistance_[block] - std::sqrt(x * x + y * y + z * z) - brick::kRounding, kExactLimit);
      const float root = std::sqrt(exact[i]);
      const float least = root <= kExactLimit ? std::max(root - brick::kRounding, 0.0f) : bound;
      steps[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(least * (1 / kDistanceStep)));
    }
    for (int i = 0; i < kBlock; ++i) distance[brick::cornerIndex(block, i)] = steps[i];
  }
}

void BrickMaker::fillWords(const std::uint16_t* distance, std::uint32_t* word) const {
  const auto farthest = static_cast<std::uint16_t>((lists_ ? kListLimit : kNearestLimit) / kDistanceStep);
  const auto& known = lists_ ? list_ : nearest_;
  for (int corner = 0; corner < kCornersPerBrick; ++corner) {
    word[corner] = distance[corner] > farthest ? kNoWord : known[corner];
  }
}

// Ends the list under construction, which becomes the list of `corner`.
void BrickMaker::addList(std::uint32_t corner) {
  list_[corner] = static_cast<std::uint32_t>(listBegin_);
  listed_.back() |= kLastOfList;
  listBegin_ = listed_.size();
}

// Appends the corners' lists to `entries`, in the order of corners, and sets the corners' words to the start of their
// lists.
void BrickMaker::placeLists(std::uint32_t* word, std::vector<std::uint32_t>& entries) {
  const std::size_t start = entries.size();
  for (int corner = 0; corner < kCornersPerBrick; ++corner) {
    if (word[corner] == kNoWord) continue;
    const std::uint32_t* entry = &listed_[word[corner]];
    word[corner] = static_cast<std::uint32_t>(entries.size() - start);
    do {
      entries.push_back(*entry);
    } while (*entry++ < kLastOfList);
  }
}

}  // namespace scanmill
