#pragma once

// Eye-dome lighting: what lies behind a nearer surface is darkened at its edge, so that a cloud of points, which has no
// normals to be lit by, shows its shapes (Boucheny, "Interactive scientific visualization of large datasets: towards a
// perceptive-based approach", 2009).

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>

#include "viewer/canvas/canvas.h"

namespace scanmill {

class DepthEdges {
 public:
  // Multiplies colours in the view's rectangle of a window `height` pixels high. Depths and the background stay as they
  // are.
  void darken(vtkOpenGLRenderWindow* window, const CanvasView& view, int height);
  void release(vtkWindow* window);

 private:
  unsigned vertexArray_ = 0;
  vtkNew<vtkOpenGLFramebufferObject> frame_;  // the window's colours without its depths, which are read
};

}  // namespace scanmill
