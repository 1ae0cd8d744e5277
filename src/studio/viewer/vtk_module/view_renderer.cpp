#include "viewer/vtk_module/view_renderer.h"

#include <vtkCamera.h>
#include <vtkCullerCollection.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>

#include <algorithm>
#include <cmath>

namespace scanmill {

vtkStandardNewMacro(ViewRenderer);

void ViewRenderer::setView(const ScanmillCanvasView& view, int canvasWidth, int canvasHeight) {
  view_ = view;
  canvasHeight_ = canvasHeight;
  // Cullers ask for bounds, which points that are not finite spoil, and which take as long to find as to draw.
  GetCullers()->RemoveAllItems();
  // What a canvas that has become smaller no longer holds is cut off until its views are set again.
  const auto fraction = [](std::uint32_t pixel, int side) { return std::min(1.0, static_cast<double>(pixel) / side); };
  SetViewport(fraction(view.left, canvasWidth), 1 - fraction(view.top + view.height, canvasHeight),
              fraction(view.left + view.width, canvasWidth), 1 - fraction(view.top, canvasHeight));
  SetBackground(view.background[0] / 255.0, view.background[1] / 255.0, view.background[2] / 255.0);

  vtkCamera* camera = GetActiveCamera();
  const double* eye = view.eye;
  camera->SetPosition(eye);
  camera->SetFocalPoint(eye[0] + view.forward[0], eye[1] + view.forward[1], eye[2] + view.forward[2]);
  camera->SetViewUp(view.up);
  const double halfHeight = view.height / 2.0 / view.focal;
  camera->SetParallelProjection(view.orthographic != 0);
  if (view.orthographic != 0) {
    camera->SetParallelScale(halfHeight);
  } else {
    constexpr double kDegrees = 180 / 3.14159265358979323846;
    camera->SetViewAngle(2 * std::atan(halfHeight) * kDegrees);
  }
  camera->SetClippingRange(view.nearest, view.farthest);
}

void ViewRenderer::DeviceRenderOpaqueGeometry(vtkFrameBufferObjectBase* frame) {
  vtkOpenGLRenderer::DeviceRenderOpaqueGeometry(frame);
  if (view_.depthEdges != 0 && edges_ != nullptr) {
    edges_->darken(static_cast<vtkOpenGLRenderWindow*>(GetRenderWindow()), view_, canvasHeight_);
  }
}

// vtkOpenGLActor leaves the depths alone while a renderer draws what is translucent.
void ViewRenderer::DeviceRenderTranslucentPolygonalGeometry(vtkFrameBufferObjectBase*) {
  UpdateTranslucentPolygonalGeometry();
}

}  // namespace scanmill
