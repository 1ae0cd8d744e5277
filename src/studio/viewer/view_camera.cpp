#include "viewer/view_camera.h"

#include <algorithm>
#include <cmath>

#include "viewer/window/orbit_camera.h"

namespace scanmill {

Projected ViewCamera::project(const Vec3d& point) const {
  const Vec3d p = point - eye;
  Projected out;
  out.depth = dot(p, forward);
  out.scale = orthographic ? focal : focal / out.depth;
  out.x = centerX + dot(p, right) * out.scale;
  out.y = centerY + dot(p, down) * out.scale;
  return out;
}

ViewCamera makeCamera(View view, int width, int height, double zoom, const std::optional<CloseUp>& closeUp) {
  constexpr double kStandOff = 4;  // distance from the centre, as a multiple of the ball's radius; gives little
                                   // perspective and an angle of 29 degrees
  constexpr double kFilled = 0.97;
  OrbitCamera turned = presetCamera(view);
  if (closeUp) {
    turned.orthographic = false;
    turned.target = closeUp->at;
    turned.distance = kStandOff * closeUp->within;
  }
  ViewCamera camera = turned.camera(width, height);
  if (closeUp) {
    // The ball's outline touches the edges of the picture.
    camera.focal = kFilled * std::min(width, height) / 2 * std::sqrt(kStandOff * kStandOff - 1);
    camera.nearest = closeUp->within;
  }
  camera.focal *= zoom;
  return camera;
}

}  // namespace scanmill
