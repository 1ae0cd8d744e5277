#pragma once

// Makes the canvas's events from those of X.

#include <X11/Xlib.h>

#include <optional>

// Xlib's macro would replace a name in the headers that follow.
#undef Above

#include "viewer/canvas/canvas.h"

namespace scanmill {

class XEvents {
 public:
  XEvents(Display* display, Window window, int width, int height);
  ~XEvents();
  XEvents(const XEvents&) = delete;
  XEvents& operator=(const XEvents&) = delete;

  // Takes one event from the queue, with those of its kind right behind it that it makes obsolete: of a run of moves
  // the last counts. nullopt where the canvas has no such event.
  std::optional<CanvasEvent> take();
  CanvasEvent plain(CanvasEvent::Kind kind) const;
  // The window's size as the server knows it.
  CanvasEvent size();

 private:
  CanvasEvent at(CanvasEvent::Kind kind, int x, int y, unsigned modifiers);
  CanvasEvent key(XKeyEvent& event);
  std::optional<CanvasEvent> button(const XButtonEvent& event, bool down);
  std::optional<CanvasEvent> configured(int width, int height);

  Display* display_;
  Window window_;
  Atom protocols_;
  Atom deleteWindow_;
  XIM method_ = nullptr;
  XIC context_ = nullptr;
  int width_;
  int height_;
  int x_ = 0;
  int y_ = 0;
  XButtonEvent lastPress_{};
  int clicks_ = 0;  // of the last press
};

}  // namespace scanmill
