#pragma once

// Internal to the depth camera's sampling: computes the ranges of beams from the pixels that they fall into.

#include <cstddef>

#include "methods/depth_camera/views.h"
#include "passes/pass_image.h"

namespace scanmill {

// Hits of a block of beams.
struct Met {
  alignas(64) double a[kBlock], b[kBlock], depth[kBlock];  // coordinates in the plane at depth 1, and depth (m)
  alignas(64) double px[kBlock], py[kBlock], pz[kBlock];   // m, hit point in rig axes
  alignas(64) double nx[kBlock], ny[kBlock], nz[kBlock];   // normal in rig axes
  alignas(64) double range[kBlock];                        // m, range of the hit; NaN or infinite if nothing is hit
  alignas(64) double along[kBlock];                        // dot product of normal and beam direction
  bool again[kBlock];                                      // true if the next round must sample another pixel
};

// Pixels of the beams of a block: their positions in the image, and their values.
struct BlockPixels {
  const double* u;  // px, column in the image, by beam of the block
  const double* v;
  const PassPlanes* planes;  // values of the batch's pixels
  std::size_t first;         // index in `planes` of the block's first pixel
};

// Fills `met`, except `again`, for the beams from `begin` to before `end` of a block, all of which fall into one image.
void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, Met& met);

}  // namespace scanmill
