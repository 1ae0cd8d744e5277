#include "pipeline/resources.h"

#include <cstdlib>
#include <system_error>

#include "pipeline/version.h"

namespace scanmill {

std::filesystem::path resourceFolder() {
  if (const char* folder = std::getenv("SCANMILL_RESOURCES")) return folder;
  std::error_code ignored;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::filesystem::path installed = program.parent_path().parent_path() / "share" / "scanmill";
  return std::filesystem::is_directory(installed / "pipelines", ignored) ? installed
                                                                         : std::filesystem::path(kSourceFolder);
}

}  // namespace scanmill
