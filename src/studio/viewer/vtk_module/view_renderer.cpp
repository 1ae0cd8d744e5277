#include "viewer/vtk_module/view_renderer.h"

#include <vtkCamera.h>
#include <vtkCullerCollection.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>

#include <algorithm>
#include <cmath>

namespace scanmill {

vtkStandardNewMacro(ViewRenderer);

void ViewRenderer::setView(const CanvasView& view, int canvasWidth, int canvasHeight) {
  view_ = view;
  canvasHeight_ = canvasHeight;
  // Removes VTK's cullers, since they need the bounds of items: points that are not finite make bounds invalid, and
  // computing bounds takes as long as drawing.
  GetCullers()->RemoveAllItems();
  // If the canvas has become smaller, views that extend beyond its edges are clipped until setViews() is called again.
  const auto fraction = [](int pixel, int side) { return std::min(1.0, static_cast<double>(pixel) / side); };
  const PixelRect& rect = view.rect;
  SetViewport(fraction(rect.left, canvasWidth), 1 - fraction(rect.top + rect.height, canvasHeight),
              fraction(rect.left + rect.width, canvasWidth), 1 - fraction(rect.top, canvasHeight));
  SetBackground(view.background[0] / 255.0, view.background[1] / 255.0, view.background[2] / 255.0);

  const ViewCamera& from = view.camera;
  const Vec3d at = from.eye + from.forward;
  const Vec3d up = -from.down;
  vtkCamera* camera = GetActiveCamera();
  camera->SetPosition(from.eye.x, from.eye.y, from.eye.z);
  camera->SetFocalPoint(at.x, at.y, at.z);
  camera->SetViewUp(up.x, up.y, up.z);
  const double halfHeight = rect.height / 2.0 / from.focal;
  camera->SetParallelProjection(from.orthographic);
  if (from.orthographic) {
    camera->SetParallelScale(halfHeight);
  } else {
    camera->SetViewAngle(degrees(2 * std::atan(halfHeight)));
  }
  camera->SetClippingRange(from.nearest, view.farthest);
}

void ViewRenderer::DeviceRenderOpaqueGeometry(vtkFrameBufferObjectBase* frame) {
  vtkOpenGLRenderer::DeviceRenderOpaqueGeometry(frame);
  if (view_.depthEdges && edges_ != nullptr) {
    edges_->darken(static_cast<vtkOpenGLRenderWindow*>(GetRenderWindow()), view_, canvasHeight_);
  }
}

// Draws translucent items. During this call vtkOpenGLActor writes no depths.
void ViewRenderer::DeviceRenderTranslucentPolygonalGeometry(vtkFrameBufferObjectBase*) {
  UpdateTranslucentPolygonalGeometry();
}

}  // namespace scanmill
