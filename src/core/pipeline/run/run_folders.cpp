#include "pipeline/run/run_folders.h"

#include <filesystem>
#include <vector>

#include "base/error.h"

namespace scanmill {

void checkFolders(const Plan& plan, const GenerateOptions& options) {
  std::vector<std::filesystem::path> folders;
  const auto add = [&](const std::filesystem::path& folder) {
    if (folder.empty()) return;
    std::error_code ignored;
    std::filesystem::path own = std::filesystem::weakly_canonical(std::filesystem::absolute(folder), ignored);
    if (!own.has_filename()) own = own.parent_path();
    for (const std::filesystem::path& other : folders) {
      const auto relative = [](const auto& a, const auto& b) { return a.lexically_relative(b).string(); };
      if (own == other || !relative(own, other).starts_with("..") || !relative(other, own).starts_with("..")) {
        throw InputError(
            {folder.string()},
            "the dataset and each recording need separate folders: give folders that are not within one another");
      }
    }
    folders.push_back(std::move(own));
  };
  add(options.folder);
  add(options.keepHits);
  add(options.keepPasses);
  if (plan.pipeline.recording != nullptr) add(plan.pipeline.recording->folder);
}

}  // namespace scanmill
