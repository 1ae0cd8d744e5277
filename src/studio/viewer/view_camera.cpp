#include "viewer/view_camera.h"

#include "viewer/window/orbit_camera.h"

namespace scanmill {

Projected ViewCamera::project(const Vec3d& point) const {
  const Vec3d p = point - eye;
  const double depth = dot(p, forward);
  const double scale = orthographic ? focal : focal / depth;
  return {centerX + dot(p, right) * scale, centerY + dot(p, down) * scale, depth, scale};
}

ViewCamera makeCamera(View view, int width, int height, double zoom) {
  ViewCamera camera = presetCamera(view).camera(width, height);
  camera.focal *= zoom;
  return camera;
}

}  // namespace scanmill
