#include "gpu/device.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace scanmill {

std::string namedDevice() {
  const char* name = std::getenv("SCANMILL_GL_DEVICE");
  return name != nullptr ? name : "";
}

bool mayHaveCard() {
  if (!namedDevice().empty()) return true;
  for (const std::string_view file : {"/dev/nvidiactl", "/dev/dxg"}) {
    if (std::filesystem::exists(file)) return true;
  }
  const std::filesystem::path folder = "/dev/dri";
  if (!std::filesystem::is_directory(folder)) return false;
  const std::filesystem::directory_iterator files(folder);
  return std::any_of(begin(files), end(files),
                     [](const auto& file) { return file.path().filename().string().starts_with("renderD"); });
}

}  // namespace scanmill
