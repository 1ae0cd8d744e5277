#include "viewer/window/free_file.h"

#include <fmt/core.h>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

std::filesystem::path freeFile(const std::string& name, const std::string& suffix) {
  constexpr int kMost = 1000;
  const std::filesystem::path folder = std::filesystem::current_path();
  for (int i = 0; i < kMost; ++i) {
    std::filesystem::path file = folder / fmt::format("{}_{:03}{}", name, i, suffix);
    if (!std::filesystem::exists(file)) return file;
  }
  throw Error(fmt::format("{0}: {1}_000{2} to {1}_{3}{2} are there already: move some away", folder.string(), name,
                          suffix, kMost - 1));
}

std::filesystem::path savePictureOf(Canvas& canvas) {
  std::filesystem::path file = freeFile("scanmill_view", ".png");
  writeFile(file, encodePng(canvas.read()));
  return file;
}

}  // namespace scanmill
