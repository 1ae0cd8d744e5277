#pragma once

// A window with an OpenGL context, made by GLFW.

#include <functional>
#include <memory>
#include <string>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// A window that is invisible until run(). VTK's window is not used, since it calls abort() if the X server lacks a
// feature, and its interactor has fixed key bindings. OpenGL is used through EGL, as in drawing without a window. If
// the connection to the X server is lost, the program ends with a message and exit code 1, since Xlib cannot continue.
class GlfwWindow {
 public:
  // Creates the window, and makes its context current. Throws Error without a display, NoDevice without OpenGL.
  GlfwWindow(const std::string& title, int width, int height);
  ~GlfwWindow();
  GlfwWindow& operator=(GlfwWindow&&) = delete;  // neither copied nor moved

  void makeCurrent() noexcept;
  double scale() const;  // the display's scale factor for text, see Canvas::scale()
  // Shows the context's default framebuffer in the window.
  void present();
  // See Canvas::run().
  void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handler);
  // Throws the first error that GLFW has reported since the last call, if there was one.
  void check();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
