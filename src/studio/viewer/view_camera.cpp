#include "viewer/view_camera.h"

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

ViewCamera makeCamera(View view, int width, int height, double zoom) {
  ViewCamera camera = presetCamera(view).camera(width, height);
  camera.focal *= zoom;
  return camera;
}

}  // namespace scanmill
