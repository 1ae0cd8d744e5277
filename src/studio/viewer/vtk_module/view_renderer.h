#pragma once

#include <vtkOpenGLRenderer.h>

#include "viewer/canvas/canvas.h"
#include "viewer/vtk_module/depth_edges.h"

namespace scanmill {

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
