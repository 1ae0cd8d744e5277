#include "viewer/canvas/canvas.h"

#include <fmt/core.h>

#include "base/file.h"
#include "gpu/device.h"

namespace scanmill {

std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height) {
  return moduleOf<CanvasModule>().openWindow(title, width, height);
}

std::unique_ptr<Canvas> openOffscreen(int width, int height) {
  return moduleOf<CanvasModule>().openOffscreen(namedDevice(), width, height);
}

std::filesystem::path savePictureOf(Canvas& canvas) {
  constexpr int kMost = 1000;
  const std::filesystem::path folder = std::filesystem::current_path();
  for (int i = 0; i < kMost; ++i) {
    std::filesystem::path file = folder / fmt::format("scanmill_view_{:03}.png", i);
    if (std::filesystem::exists(file)) continue;
    writeFile(file, encodePng(canvas.read()));
    return file;
  }
  throw Error("{}: scanmill_view_000.png to scanmill_view_{}.png exist already: move some away", folder.string(),
              kMost - 1);
}

}  // namespace scanmill
