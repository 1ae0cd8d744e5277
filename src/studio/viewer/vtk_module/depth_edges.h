#pragma once

// Eye-dome lighting: darkens pixels beside the edge of a nearer surface, so that shapes are visible in point clouds,
// which have no normals for shading (Boucheny, "Interactive scientific visualization of large datasets: towards a
// perceptive-based approach", 2009).

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>

#include "viewer/canvas/canvas.h"

namespace scanmill {

class DepthEdges {
 public:
  // Darkens pixels in the view's rectangle. `height`: height of the window in pixels. Depths and background are not
  // changed.
  void darken(vtkOpenGLRenderWindow* window, const CanvasView& view, int height);
  void release(vtkWindow* window);

 private:
  unsigned vertexArray_ = 0;
  // A framebuffer with the window's colours, but not its depths, since the shader reads the depths.
  vtkNew<vtkOpenGLFramebufferObject> frame_;
};

}  // namespace scanmill
