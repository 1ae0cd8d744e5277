#pragma once

// From X's events to the canvas's.

#include <X11/Xlib.h>

#include <cstdint>
#include <optional>

#include "viewer/canvas/canvas_module.h"

namespace scanmill {

class XEvents {
 public:
  XEvents(Display* display, Window window, std::uint32_t width, std::uint32_t height);
  ~XEvents();
  XEvents(const XEvents&) = delete;
  XEvents& operator=(const XEvents&) = delete;

  // Takes one event from the queue, with those of its kind right behind it that it makes obsolete: of a run of moves
  // the last counts. nullopt where the canvas has no such event.
  std::optional<ScanmillCanvasEvent> take();
  ScanmillCanvasEvent plain(ScanmillCanvasEventKind kind) const;
  // The window's size as the server knows it.
  ScanmillCanvasEvent size();

 private:
  ScanmillCanvasEvent at(ScanmillCanvasEventKind kind, int x, int y, unsigned modifiers);
  ScanmillCanvasEvent key(XKeyEvent& event);
  std::optional<ScanmillCanvasEvent> button(const XButtonEvent& event, bool down);
  std::optional<ScanmillCanvasEvent> configured(int width, int height);

  Display* display_;
  Window window_;
  Atom protocols_;
  Atom deleteWindow_;
  XIM method_ = nullptr;
  XIC context_ = nullptr;
  std::uint32_t width_;
  std::uint32_t height_;
  int x_ = 0;
  int y_ = 0;
  XButtonEvent lastPress_{};
  std::uint32_t clicks_ = 0;  // of the last press
};

}  // namespace scanmill
