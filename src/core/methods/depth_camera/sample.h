#pragma once

// Samples images at the beams of a sensor.

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

struct SampleOptions {
  Sampling sampling = Sampling::Plane;
  bool halves = false;  // true: coordinates of points (camera axes) are rounded by asHalf500()
};

// Returns a coordinate (m) that is stored with 500 m added, as a half float, as LiDAR-GEIL does.
double asHalf500(double coordinate);

// The beams of one step of a revolution, in rig axes: the sensor's frame at the pose from which the step's images were
// rendered. Arrays that are not empty have equal lengths.
struct RigBeams {
  std::vector<Vec3d> origin;        // origins (m); empty if all are zero
  std::vector<Vec3d> direction;     // unit vectors
  std::vector<std::uint32_t> beam;  // index in Hits where the result is stored
  double minRange = 0;              // m, hits nearer than this are misses
  double maxRange = 0;
};

// Fills `hits` for the given beams: every channel in hits.channels and, if the source has them, the surface parameters
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
