#pragma once

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// Eye-dome lighting: darkens pixels beside the edge of a nearer surface, so that shapes are visible in point clouds,
// which have no normals for shading (Boucheny, "Interactive scientific visualization of large datasets: towards a
// perceptive-based approach", 2009).
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

// Draws one view: opaque items, then eye-dome lighting, then translucent items, whose depths are not written.
class ViewRenderer : public vtkOpenGLRenderer {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static ViewRenderer* New();

  // Sets the camera and the rectangle of the view. `canvasWidth`, `canvasHeight`: size of the canvas in pixels.
  void setView(const CanvasView& view, int canvasWidth, int canvasHeight);
  void useEdges(DepthEdges* edges) { edges_ = edges; }

  void DeviceRenderOpaqueGeometry(vtkFrameBufferObjectBase* frame) override;
  void DeviceRenderTranslucentPolygonalGeometry(vtkFrameBufferObjectBase* frame) override;

 private:
  CanvasView view_{};
  int canvasHeight_ = 0;
  DepthEdges* edges_ = nullptr;
};

}  // namespace scanmill
