#pragma once

// Chooses where a sensor's cameras look, and how large their images are.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "passes/camera.h"

namespace scanmill {

enum class CameraLayout {
  Three120,  // three square images of 120 degrees, as in LiDAR-GEIL
  Four90,    // four square images of 90 degrees
  Cube6,     // the six faces of a cube (Hossny et al.)
  Auto,      // the fewest and smallest images that hold all beams
};

struct LayoutOptions {
  CameraLayout layout = CameraLayout::Auto;
  // Pixels across an image. For Auto: at the centres of the images, pixels are as fine as those of four images of 90
  // degrees and this width.
  std::uint32_t resolution = 2048;
};

// Returns cameras for beams of these directions (unit, sensor axes: x forward, y left, z up), all at the sensor's
// origin; Camera::worldFromCamera holds sensorFromCamera. There are at most 8. Fixed layouts leave out cameras that see
// no beam. With Auto every beam lies in some image, at least half a pixel inside of its edge.
std::vector<Camera> layOutCameras(std::span<const Vec3d> directions, const LayoutOptions& options);

}  // namespace scanmill
