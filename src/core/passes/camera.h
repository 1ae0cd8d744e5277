#pragma once

// Pinhole cameras.

#include <cstdint>
#include <string>

#include "base/vec.h"

namespace scanmill {

// An ideal pinhole, without distortion. Camera axes, as OpenCV's: x right, y down, z forward (m). Pixel (column i, row
// j) covers [i, i + 1) x [j, j + 1) of the image plane, and its centre is at (i + 0.5, j + 0.5); row 0 is the top row.
//
//   u = cx + fx * x / z,  v = cy + fy * y / z
struct Camera {
  std::string name;  // a name such as "front", which becomes part of file names
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double fx = 0;  // px, focal lengths
  double fy = 0;
  double cx = 0;  // px, the principal point; may lie outside of the image
  double cy = 0;
  Pose worldFromCamera;

  std::size_t pixels() const { return std::size_t{width} * height; }
  double horizontalField() const;  // rad, between the outer edges of the image
  double verticalField() const;
  // Returns the point at depth 1 m on the line of sight through (u, v) (px), in camera axes.
  Vec3d ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1}; }
};

// Returns a camera with square pixels whose principal point is the centre of the image. `horizontalField`: rad. Throws
// InputError if the image has no pixels, or if the field is not between 0 and 180 degrees.
Camera squareCamera(std::uint32_t width, std::uint32_t height, double horizontalField);

// Returns the rotation from camera axes to the axes of a sensor or vehicle (x forward, y left, z up), for a camera that
// looks along the x axis.
Quat vehicleFromOptical();

}  // namespace scanmill
