#pragma once

// Connects Dear ImGui to a canvas: its fonts, its colours, its events and its triangles. The function that is passed to
// frame() fills the panels.

#include <functional>
#include <memory>

#include "viewer/canvas/canvas.h"
#include "viewer/image.h"

namespace scanmill {

class Toolkit {
 public:
  // `letter`: px, height of a line of text.
  Toolkit(Canvas& canvas, double letter);
  ~Toolkit();
  Toolkit(const Toolkit&) = delete;
  Toolkit& operator=(const Toolkit&) = delete;

  double letter() const;  // px
  double row() const;     // px, the height of a menu, a button or a slider

  // Makes the panels light or dark, like the background of the views.
  void suit(const Rgb& background);
  // Takes an event for the next frame.
  void take(const CanvasEvent& event);
  // Runs `panels`, which calls Dear ImGui, and gives the resulting triangles to the canvas as its overlay. Sizes that
  // depend on a panel's content are right from the second frame on.
  void frame(const std::function<void()>& panels);
  // True if in the last frame the pointer was over a panel or dragging a part of it, or if the user was typing a text.
  bool hasPointer() const;
  bool hasKeys() const;
  // Closes open menus and lists. False if none was open.
  bool closeMenus();
  // Returns how often the button was pressed at one place in quick succession: 2 is a double click.
  int clicks() const;
  bool shift() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Uploads an image for panels; textureOf() returns its texture.
void setImage(Canvas& canvas, ImageId image, const Image& picture);
// Returns the image's id as Dear ImGui's texture type.
void* textureOf(ImageId image);

}  // namespace scanmill
