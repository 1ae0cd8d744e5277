#pragma once

// Samples images at the beams of a sensor.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "passes/pass_image.h"
#include "scan/hits.h"
#include "sensors/beams.h"

namespace scanmill {

enum class Sampling {
  Nearest,       // the pixel that the beam falls into; its point's distance (PreSIL, LiDAR-GEIL)
  Bilinear,      // four pixels, unless an edge of ids or a step of depth lies between them
  Plane,         // the beam's intersection with the plane that depth and normal of its pixel give
  RowHyperbola,  // see naive.cpp, as the following two
  Equirectangular,
  PixelRow,
};

// How the depth was stored before it is sampled: what a buffer of so many bits would have kept.
enum class DepthFormat {
  Float32,  // as rendered
  Unorm24,  // a fixed-point z-buffer between near and far
  Unorm16,
  Half500,  // each coordinate of the point (camera axes) + 500 m as a half float, as in LiDAR-GEIL
};

struct SampleOptions {
  Sampling sampling = Sampling::Plane;
  DepthFormat depth = DepthFormat::Float32;
  double nearest = 0.01;   // m, of the z-buffer that Unorm24 and Unorm16 stand for
  double farthest = 1000;  // m; with antialiasing also the depth of the background
  // The source's images are so many times as wide and as high as the pixels that beams see (1, 2 or 4). A pixel's
  // depth, normal and reflectance are the mean of its subpixels', as a resolving framebuffer gives it: subpixels that
  // see nothing count with the depth it was cleared to, `farthest`, unless all of them do. Ids are those of the
  // subpixel at the centre (below and right of it).
  std::uint32_t antialiasing = 1;
};

// Depth as the format keeps it. The step of a b-bit buffer at depth z is z^2 (f - n) / (f n (2^b - 1)).
float storedDepth(float depth, DepthFormat format, double nearest, double farthest);

// Beams of one step of a revolution in the axes of the rig: the sensor's frame at the pose from which the step's images
// were drawn. A structure of arrays of equal length.
struct RigBeams {
  std::vector<Vec3d> origin;        // m; empty where all are zero
  std::vector<Vec3d> direction;     // unit
  std::vector<std::uint32_t> beam;  // index in Hits: where the result goes
  double minRange = 0;              // m
  double maxRange = 0;
  const BeamTable* table = nullptr;  // of the sensor; only the methods of naive.cpp ask for a beam's ring and column
};

// Fills `hits`, which Hits::reset() has sized, at the beams given: every channel that hits.channels names, and the
// surface parameters (roughness, metallic, retroreflectance) where the source has it. A beam that no image sees, or
// whose pixel sees nothing between the ranges, is a miss. Where beams do not start in the camera, the pixel is that of
// the point that they meet, found in at most three rounds. `worldFromRig` places the rig of the source's cameras.
// Returns how many beams no image sees.
std::uint64_t samplePixels(PixelSource& source, const Pose& worldFromRig, const RigBeams& beams,
                           const SampleOptions& options, Hits& hits);

// The passes that samplePixels() reads for such channels. The surface parameters are not among them: they follow from
// the material, unless the images come from other programs and hold them.
PassChoice passesFor(Channels channels, const SampleOptions& options);

}  // namespace scanmill
