#include "viewer/view_camera.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

void lookAt(ViewCamera& camera, const Vec3d& target) {
  camera.forward = normalized(target - camera.eye);
  camera.right = normalized(cross(camera.forward, Vec3d{0, 0, 1}));
  camera.down = cross(camera.forward, camera.right);
}

// The tangents on the ball from `kStandOff` radii away touch the picture's edges.
void moveTo(ViewCamera& camera, const CloseUp& closeUp, double shorterSide, double zoom) {
  constexpr double kStandOff = 4;  // nearly without foreshortening: 29 degrees across
  constexpr double kFilled = 0.97;
  camera.orthographic = false;
  camera.eye = closeUp.at - camera.forward * (kStandOff * closeUp.within);
  camera.nearest = closeUp.within;
  camera.focal = kFilled * shorterSide / 2 * std::sqrt(kStandOff * kStandOff - 1) * zoom;
}

}  // namespace

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
  ViewCamera camera;
  camera.centerX = width / 2.0;
  camera.centerY = height / 2.0;
  // As wide an angle as a picture of 16 : 9 needs, whatever the shape.
  const double side = std::min(width / 16.0 * 9.0, static_cast<double>(height));
  switch (view) {
    case View::Driver:
      camera.focal = side * 0.9 * zoom;  // 89 degrees across
      break;
    case View::Above:
      camera.orthographic = true;
      camera.eye = {0, 0, 1000};  // above anything that a LiDAR reports
      camera.right = {1, 0, 0};
      camera.down = {0, -1, 0};
      camera.forward = {0, 0, -1};
      camera.focal = side / 50.0 * zoom;  // 50 m from top to bottom
      break;
    case View::Chase:
      camera.eye = {-12, 0, 6.5};
      lookAt(camera, {12, 0, -2.1});
      camera.focal = side * 1.15 * zoom;  // 75 degrees across
      break;
  }
  if (closeUp) moveTo(camera, *closeUp, std::min(width, height), zoom);
  return camera;
}

}  // namespace scanmill
