#pragma once

// The camera for a picture of a scan.

#include <array>
#include <string_view>

#include "base/vec.h"

namespace scanmill {

enum class View {
  Driver,  // looks straight ahead from the sensor's origin
  Above,   // looks straight down, x to the right and y up, without perspective
  Chase,   // looks ahead from behind and above the sensor
};
constexpr std::array<std::string_view, 3> kViewNames{"driver", "above", "chase"};

struct Projected {
  double x = 0;      // distance from the left edge (pixels)
  double y = 0;      // distance from the upper edge (pixels)
  double depth = 0;  // distance along the camera's viewing direction (m)
};

// The part of a scan to show: a ball (m, sensor frame).
struct CloseUp {
  Vec3d center;
  double radius = 1;

  bool contains(const Vec3d& point) const { return length(point - center) <= radius; }
};

// A pinhole or orthographic camera. Points are in the sensor frame or the canvas frame (m): x forward, y left, z up.
struct ViewCamera {
  bool orthographic = false;
  Vec3d eye;
  Vec3d right{0, -1, 0}, down{0, 0, -1}, forward{1, 0, 0};
  double focal = 1;    // focal length (pixels); for orthographic cameras, pixels per metre
  double centerX = 0;  // position of the optical axis in the picture (pixels)
  double centerY = 0;

  double nearest = 0.5;  // points nearer than this (m) are not drawn

  // Projects a point. If its depth is less than `nearest`, x and y are meaningless.
  Projected project(const Vec3d& point) const {
    const Vec3d p = point - eye;
    const double depth = dot(p, forward);
    const double scale = orthographic ? focal : focal / depth;
    return {centerX + dot(p, right) * scale, centerY + dot(p, down) * scale, depth};
  }
};

}  // namespace scanmill
