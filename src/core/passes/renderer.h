#pragma once

// The interface of renderers, which render the passes (depth, normals, ids ...) of a scene for pinhole cameras.

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "passes/pass_image.h"
#include "scene/scene.h"

namespace scanmill {

// The limits of an image. Surfaces are visible only at depths from `nearest` to `farthest` (m along the camera's z
// axis; 0 < nearest < farthest). Parts of the scene whose distance from the camera exceeds `reach` (m, straight line)
// may be left out.
struct DrawLimits {
  double nearest = 0.01;
  double farthest = 1000;
  double reach = std::numeric_limits<double>::infinity();
};

class PassRenderer {
 public:
  virtual ~PassRenderer() = default;
  // Renders at most 8 images, each of at least a pixel. A pixel shows the surface at the pixel's centre, without
  // antialiasing and blending. Alpha-tested materials are transparent where ray tracing lets beams pass. The returned
  // source may lock the renderer: another call of draw(), from any thread, then waits until the source is destroyed.
  // Safe to call from several threads.
  virtual std::unique_ptr<PixelSource> draw(const std::vector<Camera>& cameras, const DrawLimits& limits,
                                            PassChoice choice) = 0;
  // Returns the name of the renderer and its device, for the manifest: "VTK 9.1 on llvmpipe (LLVM 15.0.6, 256 bits)".
  virtual std::string device() const = 0;
};

// Renders with OpenGL through VTK, without an X server. The scene must outlive the renderer. Throws Error if the
// machine has no OpenGL 4.3 with EGL, with advice on what to install.
std::unique_ptr<PassRenderer> makeVtkRenderer(const Scene& scene);

// Renders with Blender's Cycles. The scene must outlive the renderer. Throws Error, with advice, if Blender is absent.
std::unique_ptr<PassRenderer> makeBlenderRenderer(const Scene& scene);

}  // namespace scanmill
