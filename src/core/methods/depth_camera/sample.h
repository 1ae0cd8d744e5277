#pragma once

// Computes the hits of a sensor's beams from the pixels of images.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "passes/pass_image.h"
#include "scan/hits.h"

namespace scanmill {

enum class Sampling {
  Nearest,  // distance of the point shown in the beam's pixel (PreSIL, LiDAR-GEIL)
  Plane,    // intersection of the beam with the plane given by depth and normal of its pixel
};

// The format in which depths are stored before they are sampled. Depths are rounded as if a buffer had this format.
enum class DepthFormat {
  Float32,  // not rounded
  Unorm24,  // fixed-point z-buffer of 24 bits between the near and the far plane
  Unorm16,
  Half500,  // each coordinate of the point (camera axes) + 500 m is a half float, as in LiDAR-GEIL
};

struct SampleOptions {
  Sampling sampling = Sampling::Plane;
  DepthFormat depth = DepthFormat::Float32;
  double nearest = 0.01;   // m, near plane of the images, and of the z-buffer for Unorm24 and Unorm16
  double farthest = 1000;  // m, far plane of the z-buffer
};

// Returns a depth (m) as the format stores it. The spacing of depths near z in a b-bit buffer is z^2 (f - n) / (f n
// (2^b - 1)), where n is `nearest` and f is `farthest`.
float storedDepth(float depth, DepthFormat format, double nearest, double farthest);

// The beams of one step of a revolution, in rig axes: the sensor's frame at the pose from which the step's images were
// rendered. Arrays that are not empty have equal lengths.
struct RigBeams {
  std::vector<Vec3d> origin;        // origins (m); empty if all are zero
  std::vector<Vec3d> direction;     // unit vectors
  std::vector<std::uint32_t> beam;  // index in Hits where the result is stored
  double minRange = 0;              // m, hits nearer than this are misses
  double maxRange = 0;
};

// Fills `hits` for the beams: every channel in hits.channels and, if the source has them, the surface parameters
// (roughness, metallic, retroreflectance). The caller must have called Hits::reset(). A beam is a miss if it is in no
// image, or if its pixel shows no surface within the range limits. If beams do not start in the camera, a beam's pixel
// is the pixel of its hit point, which is found in at most three rounds. `worldFromRig`: pose of the rig that the
// source's cameras belong to. Returns the number of beams that are in no image.
std::uint64_t samplePixels(PixelSource& source, const Pose& worldFromRig, const RigBeams& beams,
                           const SampleOptions& options, Hits& hits);

// Returns the passes that samplePixels() reads for these channels. The surface parameters are not included: they follow
// from the material, except if the images come from other programs and contain them.
PassChoice passesFor(Channels channels, const SampleOptions& options);

}  // namespace scanmill
