#pragma once

// An OpenGL context without a window, an X server or a surface.

#include <EGL/egl.h>

#include <string>
#include <vector>

namespace scanmill {

// Returns the names of the devices that can be opened, in the order in which they are tried.
std::vector<std::string> eglDevices();

class EglContext {
 public:
  // Creates a context of a device and leaves it current on the calling thread. `device`: as namedDevice() returns it
  // (gpu/device.h); if empty, a graphics card's driver is preferred to Mesa's software rasteriser. Throws NoDevice, and
  // std::invalid_argument if no device has that name.
  explicit EglContext(const std::string& device);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  // Makes the context current on the calling thread. It stays current until another context is used: drivers flush when
  // contexts change, which may take as long as a scan. Throws std::runtime_error.
  void makeCurrent();
  // Does the same, but returns false if it fails.
  bool tryMakeCurrent() noexcept;

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace scanmill
