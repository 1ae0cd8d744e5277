#pragma once

// The depth-camera method (LiDAR-GEIL): cameras at the sensor render passes, which are sampled at the beams.

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

// Consecutive columns of a revolution, and the images from which their beams are sampled, all rendered from one pose.
struct PassStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;  // pose of the sensor from which the images were rendered
  std::vector<PassImage> images;
};

class DepthCamera : public Method {
 public:
  const DepthCamera* depthCamera() const override { return this; }
  // Returns the passes that are needed to sample these channels.
  virtual PassChoice passes(Channels channels) const = 0;
  // Renders the shot's images and calls `take` for each step of the revolution, in order. The images are complete,
  // whereas trace() only reads the pixels that beams fall into.
  virtual TraceAccount draw(const Shot& shot, PassChoice choice, const std::function<void(PassStep&&)>& take) const = 0;
  // Fills `hits` for the beams of the step's columns, from the step's images; the values are the same as from trace().
  // The caller must have called Hits::reset() for the shot.
  virtual TraceAccount sample(const Shot& shot, const PassStep& step, Hits& hits) const = 0;
};

// Creates the method. YAML: depth_camera: {renderer: vtk, layout: auto, resolution: 2048, sampling: plane,
//                                          depth: float32, near_m: 0.01, far_m: 120, renders_per_turn: auto}
std::unique_ptr<Method> makeDepthCamera(const Scene& scene, Fields& options);

// Returns the depth camera with the renderer that the function `renderer` creates when it is first needed. The key
// `renderer` in `options` has no effect.
using RendererMaker = std::function<std::unique_ptr<PassRenderer>()>;
std::unique_ptr<DepthCamera> makeDepthCamera(const Scene& scene, Fields& options, RendererMaker renderer);

// Returns a method that can only sample() passes from other sources. Options for rendering have no effect.
std::unique_ptr<DepthCamera> makePassSampler(Fields& options);

}  // namespace scanmill
