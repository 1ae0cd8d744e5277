#pragma once

// The interface of the plug-in libscanmill_viewer.so (base/module.h). The plug-in draws with VTK, in a GLFW window or,
// without a window, with EGL.

#include <memory>
#include <string>

#include "base/module.h"
#include "viewer/canvas/canvas.h"

namespace scanmill {

class CanvasModule {
 public:
  static constexpr ModuleFile kFile{
      "libscanmill_viewer.so", "nothing can be shown by VTK",
      "install VTK, EGL and GLFW (on Debian the packages libvtk9-dev, libegl-dev and libglfw3-dev)"};
  virtual ~CanvasModule() = default;
  // These functions implement openWindow() and openOffscreen() of canvas.h.
  virtual std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height) const = 0;
  virtual std::unique_ptr<Canvas> openOffscreen(const std::string& device, int width, int height) const = 0;
};

}  // namespace scanmill
