#pragma once

// Internals of the depth camera's sampling: finds where beams fall in the images.

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vec.h"
#include "methods/depth_camera/sample.h"
#include "passes/pass_image.h"

namespace scanmill {

// An image and its camera, in the axes of the rig. With antialiasing, one of its pixels is the average of several
// subpixels.
struct CameraView {
  Vec3d right, down, forward;  // the camera's axes, unit
  Vec3d position;              // m
  double fx = 0;               // px
  double fy = 0;
  double cx = 0;
  double cy = 0;
  double width = 0;
  double height = 0;
  double lastU = 0;             // the largest number below width
  double lastV = 0;             // the largest number below height
  std::uint32_t rowLength = 0;  // subpixels from a row to the next
  PixelAddress first = 0;       // of the image's first subpixel
};

constexpr std::uint8_t kNoView = 0xFF;
constexpr std::size_t kBlock = 256;  // beams processed at a time: their arrays stay in the L1 cache

// Beams as a structure of arrays, rig axes.
struct BeamBlock {
  std::size_t count = 0;
  alignas(64) double ox[kBlock], oy[kBlock], oz[kBlock];  // m
  alignas(64) double dx[kBlock], dy[kBlock], dz[kBlock];
};

// Places in images: u and v (px) in the image `view`.
struct Places {
  double* u;
  double* v;
  std::uint8_t* view;  // kNoView: no image sees it
};

// Finds, for each of at most kBlock points (or directions, if `points` is false), the image that sees it nearest to the
// axis of its camera.
void place(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
           bool points, Places places);

// Finds the pixels that the sampling methods of naive.cpp read. `beam` holds the beams' indices in the table.
void placeNaive(Sampling sampling, std::span<const CameraView> views, const BeamTable& table, const BeamBlock& beams,
                const std::uint32_t* beam, Places places);

constexpr bool isNaive(Sampling sampling) {
  return sampling == Sampling::RowHyperbola || sampling == Sampling::Equirectangular || sampling == Sampling::PixelRow;
}

}  // namespace scanmill
