#include "dataset/merge.h"

#include <fmt/core.h>

#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "dataset/dataset_folder.h"
#include "dataset/folder_contents.h"
#include "dataset/shard_name.h"

namespace scanmill {

Manifest mergeDataset(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (!isUnfinished(folder) && std::filesystem::exists(folder / kManifestName, ignored)) {
    DatasetFolder::tidy(folder);
    return readManifest(folder);
  }
  const DatasetPlan plan = DatasetFolder::planned(folder);
  DatasetFolder opened(folder, FolderUse::Resume, plan);
  std::vector<DatasetPart> parts;
  std::vector<std::uint64_t> missing;
  const std::vector<std::string> names = plan.shards();
  for (std::size_t shard = 0; shard < names.size(); ++shard) {
    std::optional<DatasetPart> part = opened.kept(names[shard], DatasetFolder::Check::Size);
    if (part) {
      parts.push_back(std::move(*part));
    } else {
      missing.push_back(shard);
    }
  }
  if (!missing.empty()) {
    const std::string ranges = shardRanges(missing);
    throw InputError(
        {folder.string()},
        fmt::format(
            "{} of {} shards are missing or damaged: {}; make them by `scanmill generate PIPELINE -o {} --shards {}`",
            missing.size(), names.size(), ranges, folder.string(), ranges));
  }
  Manifest manifest = joinParts(plan, std::move(parts));
  opened.publish(manifest);
  return manifest;
}

}  // namespace scanmill
