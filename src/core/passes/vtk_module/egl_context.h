#pragma once

// An OpenGL context without a window, an X server or a surface.

#include <EGL/egl.h>

#include <stdexcept>
#include <string>

namespace scanmill {

// There is no OpenGL that will do. The text lists what was tried.
class NoDevice : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class EglContext {
 public:
  // The context of a device: a graphics card's driver, if there is one, else Mesa's rasteriser on the processor.
  // `device`: a number among EGL's devices, "software", or empty. It is current on the calling thread. Throws NoDevice;
  // of a device that is not there, invalid_argument.
  explicit EglContext(const std::string& device);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void makeCurrent();
  void release();

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace scanmill
