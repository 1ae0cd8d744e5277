#include "viewer/view_camera.h"

namespace scanmill {

Projected ViewCamera::project(const Vec3d& point) const {
  const Vec3d p = point - eye;
  const double depth = dot(p, forward);
  const double scale = orthographic ? focal : focal / depth;
  return {centerX + dot(p, right) * scale, centerY + dot(p, down) * scale, depth, scale};
}

}  // namespace scanmill
