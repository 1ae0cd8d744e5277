#pragma once

// Internal to sample.cpp: finds the pixels that beams fall into, and computes the beams' ranges from these pixels.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "methods/depth_camera/sample.h"
#include "passes/pass_image.h"

namespace scanmill {

// An image and its camera, in rig axes.
struct CameraView {
  Vec3d right, down, forward;  // unit vectors of the camera's axes
  Vec3d position;              // m, position of the camera
  double fx, fy, cx, cy;       // px, focal lengths and principal point
  double width, height;        // px
  double lastU, lastV;         // px, the largest doubles below `width` and `height`
  std::uint32_t rowLength;     // number of pixels in a row
  PixelAddress firstPixel;     // address of the image's first pixel

  // Returns the address of the pixel at (u, v) (px), which must be inside of the image.
  PixelAddress addressAt(double u, double v) const {
    return firstPixel + static_cast<PixelAddress>(static_cast<std::int32_t>(v)) * rowLength +
           static_cast<PixelAddress>(static_cast<std::int32_t>(u));
  }
};

constexpr std::uint8_t kNoView = 0xFF;
constexpr std::size_t kBlock = 256;  // beams that are processed together: their arrays stay in the L1 cache

// Beams as a structure of arrays, in rig axes.
struct BeamBlock {
  std::size_t count = 0;
  alignas(64) double ox[kBlock], oy[kBlock], oz[kBlock];  // origins (m)
  alignas(64) double dx[kBlock], dy[kBlock], dz[kBlock];
};

// Arrays for the projections of points: u and v (px) in the image with the index `view`.
struct ImagePositions {
  double* u;
  double* v;
  std::uint8_t* view;  // kNoView: no image contains the point; u and v are then 0
};

enum class ProjectedAs { Points, Directions };

// Hits of a block of beams.
struct ImageHits {
  alignas(64) double a[kBlock], b[kBlock],
      depth[kBlock];  // pixel's point: x / depth, y / depth (camera axes); depth (m)
  alignas(64) double px[kBlock], py[kBlock], pz[kBlock];  // m, hit point in rig axes
  alignas(64) double nx[kBlock], ny[kBlock], nz[kBlock];  // normal in rig axes
  alignas(64) double range[kBlock];                       // m, range of the hit; NaN or infinite if nothing is hit
  alignas(64) double cosine[kBlock];                      // dot product of normal and beam direction
  bool needsRound[kBlock];                                // true if the next round must sample another pixel
};

// Pixels of the beams of a block: their positions in the image, and their values.
struct BlockPixels {
  const double* u;  // px, column in the image, by beam of the block
  const double* v;
  const PassPlanes* planes;  // values of the batch's pixels
  std::size_t first;         // index in `planes` of the block's first pixel
};

// Returns the views of these cameras, in rig axes. Throws InputError if the cameras are too many.
std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig);

// Projects `count` points (m, rig axes) or directions, at most kBlock, into the images. If several images contain a
// point, the image in which the point has the largest depth is used.
void project(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
             ProjectedAs kind, ImagePositions positions);

// Fills `hits`, except `needsRound`, for the beams [begin, end) of a block, which all fall into the image of `view`.
void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits);

}  // namespace scanmill
