#pragma once

// A window by GLFW, with an OpenGL context.

#include <functional>
#include <memory>
#include <string>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// VTK's own window ends the program by abort() where the server lacks what it wants, and its interactor binds keys.
// This one is invisible until run(). Its OpenGL is that of EGL, as without a window. Where the connection to the server
// breaks, the program ends with a message and exit code 1: Xlib does not go on.
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
  // Asks for another size. Whoever manages the windows may give it or not: an event tells.
  void resize(int width, int height);
  // See Canvas::run().
  void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handler);
  // Throws what GLFW has complained about since the last call.
  void check();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
