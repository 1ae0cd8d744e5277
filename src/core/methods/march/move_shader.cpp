#include "gpu/compute.h"
#include "methods/field/distance_field.h"
#include "methods/march/march_gl.h"

namespace scanmill {

namespace {

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

std::string moveShader() {
  return glslConstant("kBrickStride", kBrickStride + 0u) + glslConstant("kMoveLanes", kMoveLanes + 0u) +
         glslConstant("kNewBrick", kNewBrick + 0u) + glslConstant("kNoWord", kNoWord) + kMove;
}

}  // namespace scanmill
