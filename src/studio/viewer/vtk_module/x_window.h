#pragma once

// A window of an X server, with an OpenGL context.

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "viewer/canvas/canvas_module.h"

namespace scanmill {

// No X server takes a window.
class NoScreen : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// VTK's own window ends the program by abort() where the server lacks what it wants, and its interactor binds keys;
// this one says what is wrong, and binds none. Its OpenGL is that of EGL, as without a window. It is invisible until
// run(). Where the connection to the server breaks, the program ends with a message and exit code 1: Xlib does not go
// on.
class XWindow {
 public:
  // The context is current. Throws NoScreen, and NoDevice.
  XWindow(const std::string& title, std::uint32_t width, std::uint32_t height);
  ~XWindow();
  XWindow(const XWindow&) = delete;
  XWindow& operator=(const XWindow&) = delete;

  void makeCurrent();
  // Shows what was drawn to the context's own framebuffer.
  void present();
  // Asks for another size. Whoever manages the windows may give it or not: an event tells.
  void resize(std::uint32_t width, std::uint32_t height);
  // See ScanmillCanvasModule. The handler returns false to end it.
  void run(std::uint32_t tickMilliseconds, const std::function<bool(const ScanmillCanvasEvent&)>& handler);
  // Throws what the server has complained about since the last call.
  void check();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
