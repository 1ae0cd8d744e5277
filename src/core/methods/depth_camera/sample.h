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
  Nearest,       // the distance of the point in the beam's pixel (PreSIL, LiDAR-GEIL)
  Bilinear,      // blends four pixels, unless ids or depths jump between them
  Plane,         // the beam's intersection with the plane that depth and normal of its pixel give
  RowHyperbola,  // this and the following two: see naive.cpp
  Equirectangular,
  PixelRow,
};

// The format in which depths are taken to be stored before sampling: they are rounded as in a buffer of this format.
enum class DepthFormat {
  Float32,  // as rendered
  Unorm24,  // a fixed-point z-buffer between near and far
  Unorm16,
  Half500,  // each coordinate of the point (camera axes) + 500 m as a half float, as in LiDAR-GEIL
};

struct SampleOptions {
  Sampling sampling = Sampling::Plane;
  DepthFormat depth = DepthFormat::Float32;
  double nearest = 0.01;   // m, near plane of the z-buffer that Unorm24 and Unorm16 emulate
  double farthest = 1000;  // m, its far plane; with antialiasing also the depth of the background
  // Subpixels per side of a pixel: the source's images are 1, 2 or 4 times as wide and as high as the pixels that beams
  // see. A pixel's depth, normal and reflectance are the mean of its subpixels', as when a framebuffer is resolved:
  // subpixels that see nothing count with `farthest`, the depth to which the framebuffer was cleared, unless no
  // subpixel sees anything. Ids are those of the subpixel at the centre (below and right of it).
  std::uint32_t antialiasing = 1;
};

// Returns a depth as the format stores it. The step of a b-bit buffer at depth z is z^2 (f - n) / (f n (2^b - 1)).
float storedDepth(float depth, DepthFormat format, double nearest, double farthest);

// Beams of one step of a revolution in the axes of the rig: the sensor's frame at the pose from which the step's images
// were rendered. A structure of arrays of equal length.
struct RigBeams {
  std::vector<Vec3d> origin;        // m; empty where all are zero
  std::vector<Vec3d> direction;     // unit
  std::vector<std::uint32_t> beam;  // index in Hits: where the result goes
  double minRange = 0;              // m
  double maxRange = 0;
  const BeamTable* table = nullptr;  // the sensor's table; only naive.cpp needs it, for a beam's ring and column
};

// Fills `hits`, which Hits::reset() has sized, for the given beams: every channel that hits.channels names and, if the
// source has them, the surface parameters (roughness, metallic, retroreflectance). A beam is a miss if no image sees
// it, or if its pixel sees nothing within the range limits. If beams do not start in the camera, the pixel of a beam is
// that of the point that it hits, found in at most three rounds. `worldFromRig` places the rig of the source's cameras.
// Returns how many beams no image sees.
std::uint64_t samplePixels(PixelSource& source, const Pose& worldFromRig, const RigBeams& beams,
                           const SampleOptions& options, Hits& hits);

// Returns the passes that samplePixels() reads for these channels. The surface parameters are not among them: they
// follow from the material, unless the images come from other programs and contain them.
PassChoice passesFor(Channels channels, const SampleOptions& options);

}  // namespace scanmill
