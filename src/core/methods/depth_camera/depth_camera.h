#pragma once

// The depth-camera method (LiDAR-GEIL): cameras at the sensor render passes, which are sampled at the beams.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/vec.h"
#include "methods/depth_camera/sample.h"
#include "methods/interface/method.h"
#include "passes/pass_image.h"
#include "passes/renderer.h"

namespace scanmill {

enum class CameraLayout {
  Three120,  // three square images of 120 degrees, as in LiDAR-GEIL
  Four90,    // four square images of 90 degrees
  Cube6,     // the six faces of a cube (Hossny et al.)
  Auto,      // images that cover all beams with few pixels: see layout.cpp
};

struct LayoutOptions {
  CameraLayout layout = CameraLayout::Auto;
  // Pixels across an image. With layout Auto, the pixels at the centres of the images are as fine as in four images of
  // 90 degrees with this width.
  std::uint32_t resolution = 2048;
};

// Returns cameras for beams with these directions (unit vectors, sensor axes: x forward, y left, z up). All cameras are
// at the sensor's origin, and Camera::worldFromCamera is sensorFromCamera. There are at most 8 cameras. Fixed layouts
// leave out cameras that see no beam. With Auto every beam is in some image, at least a pixel from the image's edge.
std::vector<Camera> layOutCameras(std::span<const Vec3d> directions, const LayoutOptions& options);

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
