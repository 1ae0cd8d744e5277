#pragma once

// Draws the overlay on top of the views.

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
  // Throws std::invalid_argument if an index in the overlay is out of range, or if one of its images does not exist.
  void set(Overlay overlay);
  // Draws to the framebuffer that is bound, which has this size (pixels).
  void draw(vtkOpenGLRenderWindow* window, int width, int height);
  void release(vtkWindow* window);

 private:
  std::map<ImageId, vtkNew<vtkTextureObject>> images_;
  Overlay overlay_;
  bool uploaded_ = false;  // true: the buffers contain the current overlay
  unsigned vertexArray_ = 0;
  unsigned vertices_ = 0;
  unsigned corners_ = 0;
};

}  // namespace scanmill
