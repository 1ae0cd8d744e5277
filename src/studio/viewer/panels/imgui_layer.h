#pragma once

// Connects Dear ImGui, which draws the panels, to a canvas: fonts, colours, events and triangles.

#include <functional>
#include <vector>

#include "viewer/canvas/canvas.h"

struct ImGuiContext;
struct ImGuiIO;

namespace scanmill {

class ImGuiLayer {
 public:
  // `lineHeight`: height of a line of text in pixels.
  ImGuiLayer(Canvas& canvas, double lineHeight);
  ~ImGuiLayer();
  ImGuiLayer& operator=(ImGuiLayer&&) = delete;  // neither copied nor moved

  double lineHeight() const;  // height of a line of text in pixels
  double row() const;         // height of a menu, a button or a slider in pixels

  // Stores an event, which the next frame() processes.
  void take(const CanvasEvent& event);
  // Calls `panels`, which draws with Dear ImGui, and sets the resulting triangles as the canvas's overlay. Sizes that
  // depend on a panel's contents are right from the second frame on.
  void frame(const std::function<void()>& panels);
  // These functions describe the last frame. hasPointer() is true if the pointer was over a panel or dragged a part of
  // a panel. hasKeys() is true if the user was typing text into a panel.
  bool hasPointer() const;
  bool hasKeys() const;
  // Closes open menus and lists. Returns false if none was open.
  bool closeMenus();
  // Returns how many times the button was pressed at the same place in quick succession; 2 for a double click.
  int clicks() const { return clicks_; }
  bool shift() const;  // true: the shift key was pressed at the last event of the pointer

 private:
  ImGuiIO& io() const;  // makes the context current and returns its input and output

  Canvas& canvas_;
  ImGuiContext* const context_;
  int clicks_ = 1;
  std::vector<int> pressedKeys_;  // values of ImGuiKey; released after the next frame
};

// Uploads an image for panels; textureOf() returns its texture.
void setImage(Canvas& canvas, ImageId image, const Image& picture);
// Returns the image's id as Dear ImGui's texture type.
void* textureOf(ImageId image);

}  // namespace scanmill
