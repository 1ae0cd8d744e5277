#pragma once

// Draws what lies over the views.

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
  // Throws std::invalid_argument where the overlay does not fit together, or names an image that is not there.
  void set(Overlay overlay);
  // Draws onto the framebuffer that is bound, of this size (px).
  void draw(vtkOpenGLRenderWindow* window, int width, int height);
  void release(vtkWindow* window);

 private:
  std::map<ImageId, vtkNew<vtkTextureObject>> images_;
  Overlay overlay_;
  bool uploaded_ = false;  // the overlay is in the buffers
  unsigned vertexArray_ = 0;
  unsigned vertices_ = 0;
  unsigned corners_ = 0;
};

}  // namespace scanmill
