#pragma once

// Shows the planes of EXR images, one at a time, and their values under the pointer.

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/frames/image_list.h"

namespace scanmill {

class ImageSession {
 public:
  // Reads the first image. `plane`: name of the plane to show; empty: the first. `bare`: shows the image without
  // panels. `still`: the session draws a picture, in which nothing can be clicked. Throws InputError if the image
  // cannot be read or lacks the plane.
  ImageSession(ImageList images, Canvas& canvas, const std::string& plane, bool bare, bool still = false);
  ~ImageSession();
  ImageSession(const ImageSession&) = delete;
  ImageSession& operator=(const ImageSession&) = delete;

  // Handles an event. Returns false if the session is to be closed.
  bool handle(const CanvasEvent& event);
  // Draws the image and the panels.
  void settle();
  // Returns the picture that settle() has drawn.
  Image picture();
  // Returns the name of the image that is shown.
  const std::string& name() const;
  // Returns the name of every plane and its value at a pixel of the canvas; nothing if the pixel is beside the image.
  std::optional<std::vector<std::pair<std::string, std::string>>> pick(int x, int y) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
