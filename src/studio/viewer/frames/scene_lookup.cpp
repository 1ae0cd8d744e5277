#include "viewer/frames/scene_lookup.h"

#include <fmt/core.h>

#include "base/error.h"
#include "config/file_kind.h"
#include "config/resources.h"
#include "config/value.h"
#include "pipeline/plan/dataset_plan.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

std::optional<fs::path> fileOf(const std::string& saved, const fs::path& datasetFolder) {
  for (const fs::path& folder : pipelineFolders(datasetFolder)) {
    const fs::path file = fileOfSavedPath(saved, folder);
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SceneChoice> sceneOf(const SequenceRecord* sequence, const fs::path& datasetFolder, double time,
                                   std::string& why) {
  constexpr const char* kAdvice = "give --scene FILE to see it";
  if (sequence == nullptr || sequence->sceneFile.empty()) {
    why = fmt::format("the manifest does not say which scene this is of: {}", kAdvice);
    return std::nullopt;
  }
  if (const auto file = fileOf(sequence->sceneFile, datasetFolder)) {
    return SceneChoice{*file, sequence->seed, sequence->moving ? time : 0};
  }
  why = fmt::format("the scene '{}' of the dataset is not found here: {}", sequence->sceneFile, kAdvice);
  return std::nullopt;
}

std::optional<fs::path> vehicleOf(const Manifest& manifest, const fs::path& datasetFolder) {
  if (manifest.sequences.empty() || manifest.sequences.front().vehicle.empty()) return std::nullopt;
  return fileOf(manifest.sequences.front().vehicle, datasetFolder);
}

void requireScene(const fs::path& file) {
  const Value root = readYaml(file);
  if (fileKind(root) == FileKind::Scene) return;
  if (fileKind(root) == FileKind::Pipeline) {
    throw InputError({file.string()},
                     fmt::format("is a pipeline: `scanmill generate {} -o DIR` makes the dataset that can be viewed",
                                 file.string()));
  }
  expectKind(root, FileKind::Scene);
  throw InputError({file.string()}, "is no scene: that has a list of `objects`");
}

}  // namespace scanmill
