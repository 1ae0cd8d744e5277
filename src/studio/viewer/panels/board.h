#pragma once

// Draws a picture without a window: views, and panels over them.

#include <functional>
#include <memory>

#include "viewer/canvas/canvas.h"
#include "viewer/panels/toolkit.h"

namespace scanmill {

class PictureBoard {
 public:
  // `letter`: px, see Toolkit. Throws Error as openOffscreen() does.
  PictureBoard(int width, int height, double letter)
      : canvas_(openOffscreen(width, height)), toolkit_(*canvas_, letter) {}

  Canvas& canvas() { return *canvas_; }
  void setImage(ImageId image, const Image& picture) { scanmill::setImage(*canvas_, image, picture); }
  Image draw(const std::function<void()>& panels) {
    for (int i = 0; i < 2; ++i) toolkit_.frame(panels);  // in the second frame all sizes are known
    canvas_->render();
    return canvas_->read();
  }

 private:
  std::unique_ptr<Canvas> canvas_;
  Toolkit toolkit_;
};

}  // namespace scanmill
