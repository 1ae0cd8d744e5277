#pragma once

#include <cstdint>
#include <string>

#include "config/fields.h"
#include "methods/depth_camera/layout.h"
#include "methods/depth_camera/sample.h"

namespace scanmill {

struct DepthCameraOptions {
  std::string renderer;  // vtk or blender
  std::string layoutName;
  std::string samplingName;
  std::string depthName;
  LayoutOptions layout;
  SampleOptions sample;                    // without `farthest`, which is set for each shot
  double farthest = 0;                     // m, largest depth in the images; 0: the sensor's maximum range
  std::uint32_t rendersPerRevolution = 0;  // steps of a revolution that are rendered; 0: see stepsOf()
};

DepthCameraOptions readDepthCameraOptions(Fields& fields);

}  // namespace scanmill
