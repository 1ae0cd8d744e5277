#pragma once

// The image above everything, texel by texel.

#include <vtkNew.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkTextureObject.h>

#include <cstdint>
#include <vector>

#include "viewer/vtk_module/screen_shader.h"

namespace scanmill {

class Overlay {
 public:
  Overlay();

  // rgba, the upper row first; null: none.
  void set(vtkOpenGLRenderWindow* window, std::uint32_t width, std::uint32_t height, const std::uint8_t* rgba);
  // Onto the framebuffer that is bound, of this size.
  void draw(vtkOpenGLRenderWindow* window, int width, int height);
  void release(vtkWindow* window);

 private:
  struct PixelRun {
    int left, top, width, height;
  };

  ScreenShader shader_;
  vtkNew<vtkTextureObject> texture_;
  std::vector<PixelRun> runs_;  // what is not transparent
};

}  // namespace scanmill
