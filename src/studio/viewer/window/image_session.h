#pragma once

// The planes of EXR images, one at a time, with their values under the pointer.

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
  // Reads the first image. Throws InputError for one that cannot be read, or a plane that it lacks (`plane`: its name;
  // empty: the first). `still`: for a picture, in which nothing can be pressed.
  ImageSession(ImageList images, Canvas& canvas, const std::string& plane, bool bare, bool still = false);
  ~ImageSession();
  ImageSession(const ImageSession&) = delete;
  ImageSession& operator=(const ImageSession&) = delete;

  // False: it wants to be closed.
  bool handle(const CanvasEvent& event);
  // Draws it.
  void settle();
  // What settle() has drawn.
  Image picture();
  // Of the image that is shown.
  const std::string& name() const;
  // The name of every plane and its value at a pixel of the canvas; none beside the image.
  std::optional<std::vector<std::pair<std::string, std::string>>> pick(int x, int y) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
