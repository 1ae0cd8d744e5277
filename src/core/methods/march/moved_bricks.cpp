#include "methods/march/moved_bricks.h"

#include <algorithm>
#include <cstring>

#include "base/parallel.h"
#include "gpu/compute.h"

namespace scanmill {

namespace {

constexpr std::size_t kDistanceWords = kBrickStride / 2;  // of a brick: two distances each

// Distances go two to a word. Words of bricks with lists count from the beginning of all lists.
constexpr const char* kMove = R"(
layout(std140, binding = 0) uniform MoveParameters {
  uint firstWords;  // in `fresh`, of new bricks
  uint firstLists;
};
layout(std430, binding = 0) readonly restrict buffer OldDistances { uint oldDistances[]; };
layout(std430, binding = 1) readonly restrict buffer OldWords { uint oldWords[]; };
layout(std430, binding = 2) readonly restrict buffer OldLists { uint oldLists[]; };
layout(std430, binding = 3) readonly restrict buffer Fresh { uint fresh[]; };
layout(std430, binding = 4) readonly restrict buffer Bricks { uvec4 moved[]; };
layout(std430, binding = 5) writeonly restrict buffer NewDistances { uint newDistances[]; };
layout(std430, binding = 6) writeonly restrict buffer NewWords { uint newWords[]; };
layout(std430, binding = 7) writeonly restrict buffer NewLists { uint newLists[]; };

void invoke(uint i) {
  uint b = i / kMoveLanes;
  uint lane = i % kMoveLanes;
  uvec4 brick = moved[b];
  bool isNew = brick.x >= kNewBrick;
  uint from = isNew ? brick.x - kNewBrick : brick.x;
  uint half_ = kBrickStride / 2u;
  for (uint k = lane; k < half_; k += kMoveLanes) {
    newDistances[b * half_ + k] = isNew ? fresh[from * half_ + k] : oldDistances[from * half_ + k];
  }
  for (uint k = lane; k < kBrickStride; k += kMoveLanes) {
    uint word = isNew ? fresh[firstWords + from * kBrickStride + k] : oldWords[from * kBrickStride + k];
    newWords[b * kBrickStride + k] = isNew || word == kNoWord ? word : word + brick.z - brick.y;
  }
  for (uint k = lane; k < brick.w; k += kMoveLanes) {
    newLists[brick.z + k] = isNew ? fresh[firstLists + brick.y + k] : oldLists[brick.y + k];
  }
}
)";

}  // namespace

MovedBricks movedBricks(const DistanceField& field, const std::vector<std::uint32_t>& firstList) {
  const bool lists = field.shape.lists;
  MovedBricks made;
  made.bricks.resize(field.fullBricks());
  std::vector<std::uint32_t> fresh;
  std::uint32_t entries = 0;
  for (std::uint32_t b = 0; b < made.bricks.size(); ++b) {
    const std::uint32_t from = field.before[b];
    const std::uint32_t to = lists ? field.firstList[b] : 0;
    const std::uint32_t count = lists ? field.firstList[b + 1] - to : 0;
    if (from != kNoWord) {
      made.bricks[b] = {from, lists ? firstList[from] : 0, to, count};
      continue;
    }
    made.bricks[b] = {kNewBrick + static_cast<std::uint32_t>(fresh.size()), entries, to, count};
    entries += count;
    fresh.push_back(b);
  }
  made.firstWords = static_cast<std::uint32_t>(fresh.size() * kDistanceWords);
  made.firstLists = made.firstWords + static_cast<std::uint32_t>(fresh.size() * kBrickStride);
  made.fresh.resize(made.firstLists + entries);
  parallelFor(fresh.size(), 64, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t at = std::size_t{fresh[i]} * kBrickStride;
      std::memcpy(&made.fresh[i * kDistanceWords], &field.distance[at], kBrickStride * sizeof field.distance[0]);
      std::copy_n(&field.word[at], kBrickStride, &made.fresh[made.firstWords + i * kBrickStride]);
      const auto& [from, listFrom, listTo, count] = made.bricks[fresh[i]];
      std::copy_n(field.lists.begin() + listTo, count, made.fresh.begin() + made.firstLists + listFrom);
    }
  });
  return made;
}

std::string moveShader() {
  return glslConstant("kBrickStride", kBrickStride + 0u) + glslConstant("kMoveLanes", kMoveLanes + 0u) +
         glslConstant("kNewBrick", kNewBrick + 0u) + glslConstant("kNoWord", kNoWord) + kMove;
}

}  // namespace scanmill
