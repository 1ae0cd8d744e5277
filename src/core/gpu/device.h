#pragma once

// The device that draws and computes by OpenGL: a graphics card's driver, or Mesa's rasteriser on the processor.

#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

// This machine has no OpenGL that will do. The text lists what was tried.
class NoDevice : public Error {
 public:
  using Error::Error;
};

// What to do where there is none.
constexpr std::string_view kInstallOpenGl =
    "install Mesa (on Debian the packages libegl-mesa0 and libgl1-mesa-dri) or the graphics card's driver with its EGL "
    "library";

// The device that the environment's SCANMILL_GL_DEVICE names: its number among EGL's devices, "software", or nothing
// for the best one.
std::string namedDevice();

}  // namespace scanmill
