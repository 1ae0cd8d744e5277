#include "passes/camera.h"

#include <fmt/core.h>

#include <cmath>

#include "base/error.h"

namespace scanmill {

double Camera::horizontalField() const {
  return std::atan((width - cx) / fx) + std::atan(cx / fx);
}

double Camera::verticalField() const {
  return std::atan((height - cy) / fy) + std::atan(cy / fy);
}

Camera squareCamera(std::uint32_t width, std::uint32_t height, double horizontalField) {
  if (!(horizontalField > 0 && horizontalField < kPi - 1e-9)) {
    throw InputError(
        fmt::format("a camera's field of {:g} degrees: a plane holds more than 0 and less than 180; take "
                    "several cameras",
                    degrees(horizontalField)));
  }
  if (width == 0 || height == 0)
    throw InputError(fmt::format("a camera of {} x {} pixels sees nothing", width, height));
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = width / (2 * std::tan(horizontalField / 2));
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

Quat vehicleFromOptical() {
  return {0.5, -0.5, 0.5, -0.5};
}

}  // namespace scanmill
