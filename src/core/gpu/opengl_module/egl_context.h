#pragma once

// An OpenGL context without a window, an X server or a surface.

#include <EGL/egl.h>

#include <string>
#include <vector>

namespace scanmill {

// The names of devices that a context may be asked of, in the order in which they are tried.
std::vector<std::string> eglDevices();

class EglContext {
 public:
  // Makes the context of a device and leaves it current on the calling thread. `device` is as namedDevice() gives it
  // (gpu/device.h); where it is empty, a graphics card's driver goes before Mesa's rasteriser on the processor. Throws
  // NoDevice, and std::invalid_argument where there is no device of that name.
  explicit EglContext(const std::string& device);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  // Makes it current on the calling thread, where it stays until another one's turn: drivers flush when contexts
  // change, which may take as long as a scan. Throws std::runtime_error.
  void makeCurrent();
  // Does the same where it can be done; false elsewhere.
  bool tryMakeCurrent() noexcept;

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace scanmill
