#include "viewer/vtk_module/screen_shader.h"

#include <vtkOpenGLShaderCache.h>
#include <vtk_glew.h>

#include <stdexcept>

namespace scanmill {

namespace {

// One triangle that covers the viewport.
constexpr const char* kVertex = R"(//VTK::System::Dec
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

}  // namespace

vtkShaderProgram* ScreenShader::ready(vtkOpenGLRenderWindow* window) {
  vtkShaderProgram* program = window->GetShaderCache()->ReadyShaderProgram(kVertex, fragment_, "");
  if (program == nullptr) throw std::runtime_error("a shader of the canvas cannot be built");
  if (vertexArray_ == 0) glGenVertexArrays(1, &vertexArray_);
  return program;
}

void ScreenShader::draw() {
  glBindVertexArray(vertexArray_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

void ScreenShader::release() {
  if (vertexArray_ != 0) glDeleteVertexArrays(1, &vertexArray_);
  vertexArray_ = 0;
}

}  // namespace scanmill
