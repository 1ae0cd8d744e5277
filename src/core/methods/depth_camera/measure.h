#pragma once

// Inside of the depth camera's sampling: the ranges of beams, from what their pixels hold.

#include <cstddef>

#include "methods/depth_camera/views.h"
#include "passes/pass_image.h"

namespace scanmill {

// What a block of beams meets.
struct Met {
  alignas(64) double a[kBlock], b[kBlock], depth[kBlock];  // in the plane at depth 1; m
  alignas(64) double px[kBlock], py[kBlock], pz[kBlock];   // m, the point, rig axes
  alignas(64) double nx[kBlock], ny[kBlock], nz[kBlock];   // rig axes
  alignas(64) double range[kBlock];                        // m; not a number or infinite where there is nothing
  alignas(64) double along[kBlock];                        // normal . beam
  bool again[kBlock];                                      // the point met lies in another pixel
};

// What the beams of a block look at: where they fall in the image, their pixels and, where four pixels are blended,
// those four.
struct BlockPixels {
  const double* u;  // px, of the block's beams
  const double* v;
  const PassPlanes* planes;   // of the batch
  std::size_t first;          // of the block's pixels
  const PassPlanes* corners;  // of the batch: corner k (right k % 2, down k / 2) of pixel i at k * stride + i
  std::size_t stride;
};

// Fills `met`, but for `again`, for the beams `begin` to `end` of a block, which all fall into one image.
void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, Met& met);

// The column (or row) of pixels such that u lies between its centre and the next one's; at the image's edge the nearest
// column.
double firstCorner(double u, double size);

}  // namespace scanmill
