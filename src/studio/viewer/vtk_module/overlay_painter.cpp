#include "viewer/vtk_module/overlay_painter.h"

#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkShaderProgram.h>
#include <vtk_glew.h>

#include <algorithm>
#include <cstddef>
#include <new>
#include <stdexcept>
#include <utility>

namespace scanmill {

namespace {

constexpr const char* kVertex = R"(//VTK::System::Dec
in vec2 pixel;
in vec2 place;
in vec4 color;
uniform vec2 canvasSize;
out vec2 imagePlace;
out vec4 tint;

void main() {
  imagePlace = place;
  tint = color;
  gl_Position = vec4(2.0 * pixel.x / canvasSize.x - 1.0, 1.0 - 2.0 * pixel.y / canvasSize.y, 0.0, 1.0);
}
)";

constexpr const char* kFragment = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 imagePlace;
in vec4 tint;
uniform sampler2D image;

void main() {
  gl_FragData[0] = tint * texture(image, imagePlace);
}
)";

const void* offsetPointer(std::size_t bytes) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): an offset that OpenGL takes as a pointer
  return reinterpret_cast<const void*>(bytes);
}

}  // namespace

void OverlayPainter::setImage(vtkOpenGLRenderWindow* window, ImageId image, int width, int height,
                              std::span<const Rgba> pixels) {
  vtkNew<vtkTextureObject>& texture = images_[image];
  const auto columns = static_cast<unsigned>(width);
  const auto rows = static_cast<unsigned>(height);
  if (texture->GetHandle() == 0 || texture->GetWidth() != columns || texture->GetHeight() != rows) {
    texture->SetContext(window);
    if (!texture->Allocate2D(columns, rows, 4, VTK_UNSIGNED_CHAR)) throw std::bad_alloc();
  }
  texture->Activate();
  window->GetState()->vtkglPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  texture->Deactivate();
}

void OverlayPainter::set(Overlay overlay) {
  const bool corners = std::ranges::all_of(overlay.corners, [&](auto i) { return i < overlay.vertices.size(); });
  const bool parts = std::ranges::all_of(overlay.parts, [&](const OverlayPart& part) {
    return part.first <= overlay.corners.size() && part.count <= overlay.corners.size() - part.first &&
           part.count % 3 == 0 && images_.contains(part.image);
  });
  if (!corners || !parts) throw std::invalid_argument("an overlay lacks vertices, corners or an image that it names");
  overlay_ = std::move(overlay);
  uploaded_ = false;
}

void OverlayPainter::draw(vtkOpenGLRenderWindow* window, int width, int height) {
  if (overlay_.parts.empty()) return;
  vtkOpenGLState* state = window->GetState();
  vtkShaderProgram* program = window->GetShaderCache()->ReadyShaderProgram(kVertex, kFragment, "");
  if (program == nullptr) throw std::runtime_error("the shader of the canvas's overlay cannot be built");
  if (vertexArray_ == 0) {
    glGenVertexArrays(1, &vertexArray_);
    glGenBuffers(1, &vertices_);
    glGenBuffers(1, &corners_);
  }
  glBindVertexArray(vertexArray_);
  if (!uploaded_) {
    glBindBuffer(GL_ARRAY_BUFFER, vertices_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(overlay_.vertices.size() * sizeof(OverlayVertex)),
                 overlay_.vertices.data(), GL_STREAM_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, corners_);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(overlay_.corners.size() * sizeof(std::uint32_t)),
                 overlay_.corners.data(), GL_STREAM_DRAW);
    const auto attribute = [&](const char* name, int size, GLenum type, std::size_t offset) {
      const auto at = static_cast<GLuint>(glGetAttribLocation(static_cast<GLuint>(program->GetHandle()), name));
      glEnableVertexAttribArray(at);
      glVertexAttribPointer(at, size, type, type == GL_FLOAT ? GL_FALSE : GL_TRUE, sizeof(OverlayVertex),
                            offsetPointer(offset));
    };
    attribute("pixel", 2, GL_FLOAT, offsetof(OverlayVertex, x));
    attribute("place", 2, GL_FLOAT, offsetof(OverlayVertex, u));
    attribute("color", 4, GL_UNSIGNED_BYTE, offsetof(OverlayVertex, color));
    uploaded_ = true;
  }
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglDisable(GL_CULL_FACE);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglEnable(GL_BLEND);
  state->vtkglEnable(GL_SCISSOR_TEST);
  state->vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  state->vtkglViewport(0, 0, width, height);
  const float size[2] = {static_cast<float>(width), static_cast<float>(height)};
  program->SetUniform2f("canvasSize", size);
  for (const OverlayPart& part : overlay_.parts) {
    const PixelRect& clip = part.clip;
    if (clip.width <= 0 || clip.height <= 0 || part.count == 0) continue;
    vtkTextureObject* texture = images_.at(part.image);
    texture->Activate();
    program->SetUniformi("image", texture->GetTextureUnit());
    state->vtkglScissor(clip.left, height - clip.top - clip.height, clip.width, clip.height);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(part.count), GL_UNSIGNED_INT,
                   offsetPointer(part.first * sizeof(std::uint32_t)));
    texture->Deactivate();
  }
  state->vtkglDisable(GL_SCISSOR_TEST);
  glBindVertexArray(0);
}

void OverlayPainter::release(vtkWindow* window) {
  for (auto& [id, texture] : images_) texture->ReleaseGraphicsResources(window);
  if (vertexArray_ == 0) return;
  glDeleteVertexArrays(1, &vertexArray_);
  glDeleteBuffers(1, &vertices_);
  glDeleteBuffers(1, &corners_);
  vertexArray_ = vertices_ = corners_ = 0;
}

}  // namespace scanmill
