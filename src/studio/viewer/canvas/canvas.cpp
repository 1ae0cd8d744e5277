#include "viewer/canvas/canvas.h"

#include "gpu/device.h"
#include "viewer/canvas/canvas_interface.h"

namespace scanmill {

std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height) {
  return moduleOf<CanvasModule>().openWindow(title, width, height);
}

std::unique_ptr<Canvas> openOffscreen(int width, int height) {
  return moduleOf<CanvasModule>().openOffscreen(namedDevice(), width, height);
}

}  // namespace scanmill
