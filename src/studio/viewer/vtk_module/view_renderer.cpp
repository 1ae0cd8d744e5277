#include <vtkCamera.h>
#include <vtkCullerCollection.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkShaderProgram.h>
#include <vtkTextureObject.h>
#include <vtk_glew.h>

#include "viewer/vtk_module/canvas_scene.h"

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

  const ViewCamera& viewCamera = view.camera;
  const Vec3d& eye = viewCamera.eye;
  const Vec3d target = eye + viewCamera.forward;
  const Vec3d up = -viewCamera.down;
  vtkCamera* camera = GetActiveCamera();
  camera->SetPosition(eye.x, eye.y, eye.z);
  camera->SetFocalPoint(target.x, target.y, target.z);
  camera->SetViewUp(up.x, up.y, up.z);
  // Half the picture's height: as a multiple of the depth or, if the camera is orthographic, in metres.
  const double halfHeight = rect.height / 2.0 / viewCamera.focal;
  camera->SetParallelProjection(viewCamera.orthographic);
  if (viewCamera.orthographic) {
    camera->SetParallelScale(halfHeight);
  } else {
    camera->SetViewAngle(degrees(2 * std::atan(halfHeight)));
  }
  camera->SetClippingRange(viewCamera.nearest, view.farthest);
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

namespace {

// A vertex shader that draws one triangle over the complete viewport. VTK's class vtkOpenGLQuadHelper is not used,
// since it needs fragment shaders that use its texture coordinates; the fragment shader below uses gl_FragCoord.
constexpr const char* kVertex = R"(//VTK::System::Dec
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

// A fragment shader that darkens pixels. Boucheny's formula adds up how much nearer each neighbour is, in logarithms of
// depths. This darkens every surface that slopes away from the eye, most of all roads. Here, the differences of two
// neighbours on opposite sides are added; on a plane they cancel out, so that only edges are darkened. A neighbour
// without a depth is given the depth of this pixel. Without perspective, depths are compared instead of their
// logarithms. The shader computes no logarithms, since they would take most of the time. If this pixel has the inverse
// depth u and two opposite neighbours have a and b, their differences add up to log2(a * b / u^2), so the sum over all
// pairs is the logarithm of a product.
constexpr const char* kFragment = R"(//VTK::System::Dec
//VTK::Output::Dec
uniform sampler2D depths;
uniform ivec2 first;
uniform ivec2 last;
uniform vec3 lens;  // farthest depth (m), range of depths (m), and this range in pixels
uniform int orthographic;

// Returns a multiple of the inverse depth; without perspective, of the negative depth. `depth`: from the depth buffer.
float nearness(float depth) {
  return orthographic == 1 ? -depth * lens.z : lens.x - depth * lens.y;
}
float neighbour(ivec2 pixel, float here) {
  float depth = texelFetch(depths, pixel, 0).r;
  return depth < 1.0 ? nearness(depth) : here;
}
float pair(ivec2 pixel, ivec2 step, float here) {
  if (any(lessThan(pixel - step, first)) || any(greaterThan(pixel + step, last))) return 1.0;
  float a = neighbour(pixel + step, here);
  float b = neighbour(pixel - step, here);
  return max(1.0, orthographic == 1 ? 1.0 + a + b - 2.0 * here : a * b / (here * here));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(depths, pixel, 0).r;
  float here = nearness(depth);
  float edge = pair(pixel, ivec2(2, 0), here) * pair(pixel, ivec2(0, 2), here);
  if (depth >= 1.0 || edge < 1.001) discard;
  float edge4 = edge * edge * edge * edge;
  gl_FragData[0] = vec4(vec3(max(1.0 / (edge4 * edge4), 0.35)), 1.0);
}
)";

// Focal length (pixels) that is assumed for darkening orthographic pictures.
constexpr double kUsualFocal = 800;

}  // namespace

void DepthEdges::darken(vtkOpenGLRenderWindow* window, const CanvasView& view, int height) {
  vtkOpenGLFramebufferObject* drawn = window->GetRenderFramebuffer();
  vtkTextureObject* depths = drawn->GetDepthAttachmentAsTextureObject();
  if (frame_->GetContext() == nullptr) frame_->SetContext(window);
  vtkOpenGLState* state = window->GetState();
  state->Push();
  state->PushFramebufferBindings();
  frame_->Bind();
  frame_->AddColorAttachment(0, drawn->GetColorAttachmentAsTextureObject(0));
  frame_->ActivateDrawBuffer(0);

  const PixelRect& rect = view.rect;
  const int bottom = height - (rect.top + rect.height);  // OpenGL counts rows from the bottom
  state->vtkglViewport(rect.left, bottom, rect.width, rect.height);
  state->vtkglScissor(rect.left, bottom, rect.width, rect.height);
  state->vtkglEnable(GL_SCISSOR_TEST);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglEnable(GL_BLEND);
  state->vtkglBlendFunc(GL_ZERO, GL_SRC_COLOR);

  vtkShaderProgram* program = window->GetShaderCache()->ReadyShaderProgram(kVertex, kFragment, "");
  if (program == nullptr) throw std::runtime_error("a shader of the canvas cannot be built");
  depths->Activate();
  const int first[2] = {rect.left, bottom};
  const int last[2] = {rect.left + rect.width - 1, bottom + rect.height - 1};
  const double depthRange = view.farthest - view.camera.nearest;
  const float lens[3] = {static_cast<float>(view.farthest), static_cast<float>(depthRange),
                         static_cast<float>(depthRange * view.camera.focal / kUsualFocal)};
  program->SetUniformi("depths", depths->GetTextureUnit());
  program->SetUniform2i("first", first);
  program->SetUniform2i("last", last);
  program->SetUniform3f("lens", lens);
  program->SetUniformi("orthographic", view.camera.orthographic ? 1 : 0);
  if (vertexArray_ == 0) glGenVertexArrays(1, &vertexArray_);
  glBindVertexArray(vertexArray_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  depths->Deactivate();

  frame_->RemoveColorAttachment(0);
  state->PopFramebufferBindings();
  state->Pop();
}

void DepthEdges::release(vtkWindow* window) {
  if (vertexArray_ != 0) glDeleteVertexArrays(1, &vertexArray_);
  vertexArray_ = 0;
  frame_->ReleaseGraphicsResources(window);
}

}  // namespace scanmill
