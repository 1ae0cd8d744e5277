#pragma once

// A fragment shader for every pixel of the viewport.

#include <vtkOpenGLRenderWindow.h>
#include <vtkShaderProgram.h>

namespace scanmill {

// VTK's own vtkOpenGLQuadHelper insists on shaders that use its texture coordinates; these go by gl_FragCoord.
class ScreenShader {
 public:
  // `fragment` is in VTK's dialect.
  explicit ScreenShader(const char* fragment) : fragment_(fragment) {}

  // Makes it the current program, whose uniforms can be set then.
  vtkShaderProgram* ready(vtkOpenGLRenderWindow* window);
  void draw();
  void release();

 private:
  const char* fragment_;
  unsigned vertexArray_ = 0;
};

}  // namespace scanmill
