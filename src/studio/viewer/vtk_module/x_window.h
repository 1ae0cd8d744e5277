#pragma once

// A window of an X server, with an OpenGL context.

#include <functional>
#include <memory>
#include <string>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// VTK's own window ends the program by abort() where the server lacks what it wants, and its interactor binds keys;
// this one says what is wrong, and binds none. Its OpenGL is that of EGL, as without a window. It is invisible until
// run(). Where the connection to the server breaks, the program ends with a message and exit code 1: Xlib does not go
// on.
class XWindow {
 public:
  // Leaves the context current. Throws NoDisplay, and NoDevice.
  XWindow(const std::string& title, int width, int height);
  ~XWindow();
  XWindow(const XWindow&) = delete;
  XWindow& operator=(const XWindow&) = delete;

  // Makes the context current on the calling thread. Throws std::runtime_error.
  void makeCurrent();
  // Does the same where it can be done; false elsewhere.
  bool tryMakeCurrent() noexcept;
  // Shows what was drawn to the context's own framebuffer.
  void present();
  // Asks for another size. Whoever manages the windows may give it or not: an event tells.
  void resize(int width, int height);
  // See Canvas::run().
  void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handler);
  // Throws what the server has complained about since the last call.
  void check();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
