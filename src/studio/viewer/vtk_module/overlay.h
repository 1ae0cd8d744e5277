#pragma once

// The image above everything, texel by texel.

#include <vtkNew.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkTextureObject.h>

#include <span>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/vtk_module/screen_shader.h"

namespace scanmill {

class Overlay {
 public:
  Overlay();

  // Takes an image of this size (px), the upper row first.
  void set(vtkOpenGLRenderWindow* window, int width, int height, std::span<const Rgba> pixels);
  // Takes the image away.
  void clear() { runs_.clear(); }
  // Draws onto the framebuffer that is bound, of this size (px).
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
