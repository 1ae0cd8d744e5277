#pragma once

// An OpenGL context without a window, an X server or a surface.

#include <EGL/egl.h>

#include <string>
#include <vector>

namespace scanmill {

// Returns the names of the devices that can be opened, in the order in which EglContext tries them.
std::vector<std::string> eglDevices();

class EglContext {
 public:
  // Creates a context on a device and makes it current on the calling thread. `device`: the result of namedDevice()
  // (gpu/device.h); if it is empty, a graphics card's driver is preferred to Mesa's software rasteriser. Throws
  // NoDevice if no device is suitable, and std::invalid_argument if no device has this name.
  explicit EglContext(const std::string& device);
  ~EglContext();
  EglContext& operator=(EglContext&&) = delete;  // neither copied nor moved

  // Makes the context current on the calling thread until another context is made current. Throws std::runtime_error
  // if this fails. Switching contexts is slow: drivers then flush, which may take as long as tracing a scan.
  void makeCurrent();
  // Does the same as makeCurrent(), but returns false instead of throwing.
  bool tryMakeCurrent() noexcept;

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace scanmill
