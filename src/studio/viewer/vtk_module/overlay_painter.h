#pragma once

// Draws the overlay over the views.

#include <vtkNew.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkTextureObject.h>

#include <map>
#include <span>

#include "viewer/canvas/canvas.h"

namespace scanmill {

class OverlayPainter {
 public:
  void setImage(vtkOpenGLRenderWindow* window, ImageId image, int width, int height, std::span<const Rgba> pixels);
  // Throws std::invalid_argument if an index of the overlay is out of range, or one of its images does not exist.
  void set(Overlay overlay);
  // Draws onto the bound framebuffer, which has this size (px).
  void draw(vtkOpenGLRenderWindow* window, int width, int height);
  void release(vtkWindow* window);

 private:
  std::map<ImageId, vtkNew<vtkTextureObject>> images_;
  Overlay overlay_;
  bool uploaded_ = false;  // the buffers hold the overlay
  unsigned vertexArray_ = 0;
  unsigned vertices_ = 0;
  unsigned corners_ = 0;
};

}  // namespace scanmill
