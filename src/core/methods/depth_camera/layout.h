#pragma once

// Chooses the directions in which a sensor's cameras look, and the sizes of their images.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "passes/pass_image.h"

namespace scanmill {

enum class CameraLayout {
  Three120,  // three square images of 120 degrees, as in LiDAR-GEIL
  Four90,    // four square images of 90 degrees
  Cube6,     // the six faces of a cube (Hossny et al.)
  Auto,      // images that cover all beams with few pixels: see layout.cpp
};

struct LayoutOptions {
  CameraLayout layout = CameraLayout::Auto;
  // Pixels across an image. With layout Auto, the pixels at the centres of the images are as fine as in four images of
  // 90 degrees with this width.
  std::uint32_t resolution = 2048;
};

// Returns cameras for beams with these directions (unit vectors, sensor axes: x forward, y left, z up). All cameras are
// at the sensor's origin, and Camera::worldFromCamera is sensorFromCamera. There are at most 8 cameras. Fixed layouts
// leave out cameras that see no beam. With Auto every beam is in some image, at least a pixel from the image's edge.
std::vector<Camera> layOutCameras(std::span<const Vec3d> directions, const LayoutOptions& options);

}  // namespace scanmill
