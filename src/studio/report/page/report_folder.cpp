#include "report/page/report_folder.h"

#include <fmt/core.h>

#include "base/error.h"

namespace scanmill {

namespace fs = std::filesystem;

void prepareReportFolder(const fs::path& folder, const std::string& result, bool overwrite) {
  try {
    if (fs::exists(folder) && !fs::is_directory(folder)) {
      throw InputError({folder.string()}, "is a file: name another folder");
    }
    fs::create_directories(folder);
    if (fs::is_empty(folder)) return;
    if (!fs::exists(folder / result)) {
      throw InputError({folder.string()}, fmt::format("has files, but no {}: name another folder", result));
    }
    if (!overwrite) throw InputError({folder.string()}, "has a report: add --overwrite, or name another folder");
  } catch (const fs::filesystem_error& error) {
    throw InputError({folder.string()}, "cannot be used as the folder of a report: " + error.code().message());
  }
}

void beginReport(const fs::path& folder, const std::string& result) {
  std::error_code failure;
  fs::remove(folder / result, failure);
  if (failure) throw Error(fmt::format("{}: cannot be removed: {}", (folder / result).string(), failure.message()));
}

}  // namespace scanmill
