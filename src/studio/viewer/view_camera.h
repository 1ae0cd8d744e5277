#pragma once

// The camera of a picture of a scan.

#include <array>
#include <string_view>

#include "base/vec.h"

namespace scanmill {

enum class View {
  Driver,  // from the sensor's origin, straight ahead
  Above,   // straight down, x to the right and y up, without perspective
  Chase,   // from behind and above the sensor
};
constexpr std::array<std::string_view, 3> kViewNames{"driver", "above", "chase"};

struct Projected {
  double x = 0;      // pixels from the left edge
  double y = 0;      // pixels from the upper edge
  double depth = 0;  // m along the line of sight
  double scale = 0;  // pixels per metre at that depth
};

// The part of a scan to look at: the ball of radius `within` about `at`. Metres, sensor frame.
struct CloseUp {
  Vec3d at;
  double within = 1;

  bool holds(const Vec3d& point) const { return length(point - at) <= within; }
};

// A pinhole, or an orthographic camera. Points are in the sensor frame: x forward, y left, z up, metres.
struct ViewCamera {
  bool orthographic = false;
  Vec3d eye;
  Vec3d right{0, -1, 0};
  Vec3d down{0, 0, -1};
  Vec3d forward{1, 0, 0};
  double focal = 1;    // pixels; orthographic: pixels per metre
  double centerX = 0;  // pixels
  double centerY = 0;

  double nearest = 0.5;  // m; nearer points are not seen

  // Projects a point. x, y and scale are meaningless if the depth is below `nearest`.
  Projected project(const Vec3d& point) const;
};

// Returns the camera for a picture of width x height pixels; `zoom` makes everything that many times larger.
ViewCamera makeCamera(View view, int width, int height, double zoom);

}  // namespace scanmill
