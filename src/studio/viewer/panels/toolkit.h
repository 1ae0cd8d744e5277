#pragma once

// Dear ImGui on a canvas: its fonts, its looks, the events that it gets and the triangles that it makes. What is in the
// panels is said by whoever calls it in frame().

#include <functional>
#include <memory>

#include "viewer/canvas/canvas.h"
#include "viewer/image.h"

namespace scanmill {

class Toolkit {
 public:
  // Letters are `letter` pixels high with what is above and below them.
  Toolkit(Canvas& canvas, double letter);
  ~Toolkit();
  Toolkit(const Toolkit&) = delete;
  Toolkit& operator=(const Toolkit&) = delete;

  double letter() const;  // px
  double row() const;     // px, the height of a menu, a button or a slider

  // Light or dark, as what lies behind the panels is.
  void suit(const Rgb& background);
  // Takes an event, which counts in the frames that follow.
  void take(const CanvasEvent& event);
  // Runs `panels`, which calls Dear ImGui, and hands the canvas what it draws. Sizes that follow from what a panel
  // holds are right from the second frame on.
  void frame(const std::function<void()>& panels);
  // As of the last frame: the pointer is over a panel or holds something of one; a text is being typed.
  bool hasPointer() const;
  bool hasKeys() const;
  // Closes menus and lists that are open. False: none was.
  bool closeMenus();
  // The button went down so many times at one place: 2 is a double click.
  int clicks() const;
  bool shift() const;

  // An image for panels, whose texture is its number.
  void setImage(ImageId image, const Image& picture);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// An image as Dear ImGui names it.
void* textureOf(ImageId image);

}  // namespace scanmill
