#pragma once

#include <vtkOpenGLRenderer.h>

#include "viewer/canvas/canvas.h"
#include "viewer/vtk_module/depth_edges.h"

namespace scanmill {

// Draws one view: first opaque items, then eye-dome lighting, then translucent items, which write no depths.
class ViewRenderer : public vtkOpenGLRenderer {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static ViewRenderer* New();

  // Sets the camera and the rectangle of the view on a canvas of this size (px).
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
