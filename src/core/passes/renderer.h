#pragma once

// A renderer draws passes of a scene.

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "passes/pass_image.h"
#include "scene/scene.h"

namespace scanmill {

// What bounds the view. Surfaces nearer to the camera's plane than `nearest` are not seen, nor those farther than
// `farthest` (both m, along the camera's z axis; 0 < nearest < farthest). What is farther than `reach` from the camera
// (m, in a straight line) is of no interest: it may be left out, piece by piece.
struct DrawLimits {
  double nearest = 0.01;
  double farthest = 1000;
  double reach = std::numeric_limits<double>::infinity();
};

class PassRenderer {
 public:
  virtual ~PassRenderer() = default;
  // Draws at most 8 images, the pixel's centre deciding what it sees: no antialiasing, no blending. Alpha-tested
  // materials let the view pass where ray tracing lets beams pass. The source holds the renderer: a further call, from
  // any thread, waits until it is gone. Safe to call from several threads.
  virtual std::unique_ptr<PixelSource> draw(const std::vector<Camera>& cameras, const DrawLimits& limits,
                                            PassChoice choice) = 0;
  // Of all calls since it was made: "upload" (of the scene), "render", "read_back".
  virtual StageSeconds seconds() const = 0;
  // What draws, for the manifest: "VTK 9.1 on llvmpipe (LLVM 15.0.6, 256 bits)".
  virtual std::string device() const = 0;
};

// By OpenGL through VTK, without an X server. The scene must outlive it. Throws Error where the machine has no OpenGL
// 4.3 by EGL, and says what to install.
std::unique_ptr<PassRenderer> makeVtkRenderer(const Scene& scene);

// By Blender's Cycles. The scene must outlive it. Throws Error where there is no Blender, and says how to install it.
std::unique_ptr<PassRenderer> makeBlenderRenderer(const Scene& scene);

}  // namespace scanmill
