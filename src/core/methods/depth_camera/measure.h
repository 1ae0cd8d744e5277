#pragma once

// Internals of the depth camera's sampling: computes the ranges of beams from their pixels.

#include <cstddef>

#include "methods/depth_camera/views.h"
#include "passes/pass_image.h"

namespace scanmill {

// The hits of a block of beams.
struct Met {
  alignas(64) double a[kBlock], b[kBlock], depth[kBlock];  // a and b in the plane at depth 1; depth in m
  alignas(64) double px[kBlock], py[kBlock], pz[kBlock];   // m, the hit point, rig axes
  alignas(64) double nx[kBlock], ny[kBlock], nz[kBlock];   // rig axes
  alignas(64) double range[kBlock];                        // m; NaN or infinite if nothing is hit
  alignas(64) double along[kBlock];                        // normal . beam
  bool again[kBlock];                                      // the hit point lies in another pixel
};

// The pixels of the beams of a block: where each beam falls in the image, its pixel and, if four pixels are blended,
// those four.
struct BlockPixels {
  const double* u;  // px, of the block's beams
  const double* v;
  const PassPlanes* planes;   // pixels of the batch
  std::size_t first;          // index of the block's first pixel
  const PassPlanes* corners;  // of the batch: corner k (right k % 2, down k / 2) of pixel i at k * stride + i
  std::size_t stride;
};

// Fills `met`, except for `again`, for the beams `begin` to `end` of a block, which all fall into one image.
void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, Met& met);

// Returns the column (or row) of pixels such that u lies between its centre and the centre of the next one; at the
// image's edge, the nearest column.
double firstCorner(double u, double size);

}  // namespace scanmill
