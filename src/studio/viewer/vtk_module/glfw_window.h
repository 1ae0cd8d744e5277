#pragma once

// A GLFW window with an OpenGL context.

#include <functional>
#include <memory>
#include <string>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// VTK's own window is not used: it calls abort() if the X server lacks a feature, and its interactor binds keys. This
// window is invisible until run(). It uses OpenGL through EGL, as drawing without a window does. If the connection to
// the display breaks, Xlib ends the program with a message and exit code 1.
class GlfwWindow {
 public:
  // Leaves the context current. Throws NoDisplay, and NoDevice.
  GlfwWindow(const std::string& title, int width, int height);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  void makeCurrent() noexcept;
  double scale() const;  // see Canvas
  // Shows what was drawn to the context's own framebuffer.
  void present();
  // Requests another size, which the window manager may refuse: a Resize event reports the new size.
  void resize(int width, int height);
  // See Canvas::run().
  void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handler);
  // Throws the first error that GLFW has reported since the last call.
  void check();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
