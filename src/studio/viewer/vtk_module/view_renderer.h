#pragma once

#include <vtkOpenGLRenderer.h>

#include "viewer/canvas/canvas_module.h"
#include "viewer/vtk_module/depth_edges.h"

namespace scanmill {

// Draws one view: what is opaque, the edges of its depths, and above both, without writing depths, what is translucent.
class ViewRenderer : public vtkOpenGLRenderer {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static ViewRenderer* New();

  // For a canvas of this size.
  void setView(const ScanmillCanvasView& view, int canvasWidth, int canvasHeight);
  void useEdges(DepthEdges* edges) { edges_ = edges; }

  void DeviceRenderOpaqueGeometry(vtkFrameBufferObjectBase* frame) override;
  void DeviceRenderTranslucentPolygonalGeometry(vtkFrameBufferObjectBase* frame) override;

 private:
  ScanmillCanvasView view_{};
  int canvasHeight_ = 0;
  DepthEdges* edges_ = nullptr;
};

}  // namespace scanmill
