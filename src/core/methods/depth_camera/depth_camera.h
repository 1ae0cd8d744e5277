#pragma once

// The depth-camera method (LiDAR-GEIL): passes are drawn by cameras at the sensor and sampled at the beams.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "methods/depth_camera/layout.h"
#include "methods/depth_camera/sample.h"
#include "methods/interface/method.h"
#include "passes/pass_image.h"
#include "passes/renderer.h"

namespace scanmill {

// Consecutive columns of a revolution, and the images, drawn from one pose, from which their beams are sampled.
struct PassStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;  // of the sensor when the images were drawn
  std::vector<PassImage> images;
};

class DepthCamera : public Method {
 public:
  const DepthCamera* depthCamera() const override { return this; }
  // The passes from which such channels are sampled.
  virtual PassChoice passes(Channels channels) const = 0;
  // Draws the shot's images and hands them to `take`, one step of the revolution after the other. These images are
  // whole; trace() reads only the pixels that its beams fall into.
  virtual TraceAccount draw(const Shot& shot, PassChoice choice, const std::function<void(PassStep&&)>& take) const = 0;
  // Fills `hits` at the beams of the step's columns, from its images: the same bytes as trace() gives. The caller has
  // called Hits::reset() for the shot.
  virtual TraceAccount sample(const Shot& shot, const PassStep& step, Hits& hits) const = 0;
};

// YAML: depth_camera: {renderer: vtk, layout: auto, resolution: 2048, sampling: plane, depth: float32, antialiasing: 1,
//                      near_m: 0.01, far_m: 120, renders_per_turn: auto}
std::unique_ptr<Method> makeDepthCamera(const Scene& scene, Fields& options);

// The same with another renderer, which is made when it is first needed; the option `renderer` has no effect.
using RendererMaker = std::function<std::unique_ptr<PassRenderer>()>;
std::unique_ptr<DepthCamera> makeDepthCamera(const Scene& scene, Fields& options, RendererMaker renderer);

// Without scene and renderer, for sample() alone: it samples passes that come from elsewhere. The options of drawing
// have no effect.
std::unique_ptr<DepthCamera> makePassSampler(Fields& options);

}  // namespace scanmill
