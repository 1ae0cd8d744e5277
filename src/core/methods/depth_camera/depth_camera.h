#pragma once

// The depth-camera method (LiDAR-GEIL): passes are drawn by cameras at the sensor and sampled at the beams.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "methods/depth_camera/layout.h"
#include "methods/depth_camera/sample.h"
#include "methods/method.h"
#include "passes/pass_image.h"
#include "passes/renderer.h"

namespace scanmill {

// A stretch of a turn whose beams are sampled from images of one pose.
struct PassStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;  // of the sensor when the images were drawn
  std::vector<PassImage> images;
};

class DepthCamera : public Method {
 public:
  const DepthCamera* depthCamera() const override { return this; }
  // Which passes sampling such channels takes.
  virtual PassChoice passes(Channels channels) const = 0;
  // Draws whole images in place of the pixels that the beams need, step by step of the turn.
  virtual TraceAccount draw(const Shot& shot, PassChoice choice, const std::function<void(PassStep&&)>& take) const = 0;
  // Samples the beams of the step's columns from its images: the same bytes as trace() gives. Hits::reset has been
  // called.
  virtual TraceAccount sample(const Shot& shot, const PassStep& step, Hits& hits) const = 0;
};

// YAML: depth_camera: {renderer: vtk, layout: auto, resolution: 2048, sampling: plane, depth: float32, antialiasing: 1,
//                      near_m: 0.01, far_m: 120, renders_per_turn: auto}
std::unique_ptr<Method> makeDepthCamera(const Scene& scene, Fields& options);

// The same with a renderer of one's own, made when it is first needed; `renderer` of the options is not looked at.
using RendererMaker = std::function<std::unique_ptr<PassRenderer>()>;
std::unique_ptr<DepthCamera> makeDepthCamera(const Scene& scene, Fields& options, RendererMaker renderer);

// The same with passes from elsewhere: no scene, no renderer. The options of drawing are not looked at.
std::unique_ptr<DepthCamera> makePassSampler(Fields& options);

}  // namespace scanmill
