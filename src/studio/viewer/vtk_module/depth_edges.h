#pragma once

// Eye-dome lighting: pixels beside the edge of a nearer surface are darkened, so that a point cloud, which has no
// normals for shading, shows its shapes (Boucheny, "Interactive scientific visualization of large datasets: towards a
// perceptive-based approach", 2009).

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>

#include "viewer/canvas/canvas.h"

namespace scanmill {

class DepthEdges {
 public:
  // Darkens colours in the view's rectangle of a window `height` pixels high. Depths and the background stay unchanged.
  void darken(vtkOpenGLRenderWindow* window, const CanvasView& view, int height);
  void release(vtkWindow* window);

 private:
  unsigned vertexArray_ = 0;
  vtkNew<vtkOpenGLFramebufferObject> frame_;  // the window's colours without its depths, which the shader reads
};

}  // namespace scanmill
