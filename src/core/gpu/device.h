#pragma once

// The device that renders and computes with OpenGL: a graphics card's driver, or Mesa's software rasteriser.

#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// Thrown if this machine has no suitable OpenGL. The message lists what was tried.
class NoDevice : public Error {
 public:
  using Error::Error;
};

// Advice for a machine without OpenGL.
constexpr std::string_view kInstallOpenGl =
    "install Mesa (on Debian the packages libegl-mesa0 and libgl1-mesa-dri) or the graphics card's driver with its EGL "
    "library";

// Returns the device that the environment variable SCANMILL_GL_DEVICE names: its number among EGL's devices,
// "software", or an empty text for the best one.
std::string namedDevice();

}  // namespace scanmill
