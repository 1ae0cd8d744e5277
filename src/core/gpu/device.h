#pragma once

// Selects the device that renders and computes with OpenGL: a graphics card's driver, or Mesa's software rasteriser.

#include <cstdlib>
#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// Thrown if this machine has no suitable OpenGL. The message says what is missing, for each device that was tried.
class NoDevice : public Error {
 public:
  using Error::Error;
};

// Advice in messages about a machine without OpenGL.
constexpr std::string_view kInstallOpenGl =
    "install Mesa (on Debian the packages libegl-mesa0 and libgl1-mesa-dri) or the graphics card's driver with its EGL "
    "library";

// Returns the value of the environment variable SCANMILL_GL_DEVICE: the device's number among EGL's devices,
// "software", or an empty text, which means the best device.
inline std::string namedDevice() {
  const char* name = std::getenv("SCANMILL_GL_DEVICE");
  return name != nullptr ? name : "";
}

}  // namespace scanmill
