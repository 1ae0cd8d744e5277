#pragma once

// Internal to the depth camera's sampling: finds where beams fall in the images, and computes their ranges from the
// pixels that they fall into.

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
  double fx = 0;               // px, focal lengths fx and fy, and principal point (cx, cy)
  double fy = 0;
  double cx = 0;
  double cy = 0;
  double width = 0;
  double height = 0;
  double lastU = 0;             // px, the largest double below `width`
  double lastV = 0;             // px, the largest double below `height`
  std::uint32_t rowLength = 0;  // number of pixels in a row
  PixelAddress first = 0;       // address of the image's first pixel

  PixelAddress at(double u, double v) const {
    return first + static_cast<PixelAddress>(static_cast<std::int32_t>(v)) * rowLength +
           static_cast<PixelAddress>(static_cast<std::int32_t>(u));
  }
};

// Returns the images of a source. Throws InputError if there are too many.
std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig);

constexpr std::uint8_t kNoView = 0xFF;
constexpr std::size_t kBlock = 256;  // beams that are processed together: their arrays stay in the L1 cache

// Beams as a structure of arrays, in rig axes.
struct BeamBlock {
  std::size_t count = 0;
  alignas(64) double ox[kBlock], oy[kBlock], oz[kBlock];  // origins (m)
  alignas(64) double dx[kBlock], dy[kBlock], dz[kBlock];
};

// Positions in images: u and v (px) in the image with the index `view`.
struct ImagePositions {
  double* u;
  double* v;
  std::uint8_t* view;  // kNoView: no image contains the point
};

enum class ProjectedAs { Points, Directions };

// Finds for each of at most kBlock points or directions the image in which its depth is largest, among the images that
// contain it.
void project(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
             ProjectedAs what, ImagePositions positions);

// Hits of a block of beams.
struct ImageHits {
  alignas(64) double a[kBlock], b[kBlock], depth[kBlock];  // coordinates in the plane at depth 1, and depth (m)
  alignas(64) double px[kBlock], py[kBlock], pz[kBlock];   // m, hit point in rig axes
  alignas(64) double nx[kBlock], ny[kBlock], nz[kBlock];   // normal in rig axes
  alignas(64) double range[kBlock];                        // m, range of the hit; NaN or infinite if nothing is hit
  alignas(64) double along[kBlock];                        // dot product of normal and beam direction
  bool needsRound[kBlock];                                 // true if the next round must sample another pixel
};

// Pixels of the beams of a block: their positions in the image, and their values.
struct BlockPixels {
  const double* u;  // px, column in the image, by beam of the block
  const double* v;
  const PassPlanes* planes;  // values of the batch's pixels
  std::size_t first;         // index in `planes` of the block's first pixel
};

// Fills `found`, except `needsRound`, for the beams from `begin` to before `end` of a block, all of which fall into one
// image.
void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& found);

}  // namespace scanmill
