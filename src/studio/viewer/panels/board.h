#pragma once

// Draws a picture of views and panels without a window.

#include <functional>
#include <memory>

#include "viewer/canvas/canvas.h"
#include "viewer/panels/toolkit.h"

namespace scanmill {

class PictureBoard {
 public:
  // `width`, `height`: in pixels. `letter`: height of a line of text in pixels, see Toolkit. Throws Error like
  // openOffscreen().
  PictureBoard(int width, int height, double letter)
      : canvas_(openOffscreen(width, height)), toolkit_(*canvas_, letter) {}

  Canvas& canvas() { return *canvas_; }
  void setImage(ImageId image, const Image& picture) { scanmill::setImage(*canvas_, image, picture); }
  Image draw(const std::function<void()>& panels) {
    for (int i = 0; i < 2; ++i) toolkit_.frame(panels);  // sizes that depend on contents are known in the second frame
    canvas_->render();
    return canvas_->read();
  }

 private:
  std::unique_ptr<Canvas> canvas_;
  Toolkit toolkit_;
};

}  // namespace scanmill
