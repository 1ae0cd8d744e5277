#include "viewer/frames/frame_source.h"

#include <fmt/core.h>

#include "base/error.h"
#include "base/file.h"
#include "config/resources.h"
#include "config/value.h"
#include "formats/cloud_file.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "viewer/frames/stored_frames.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Throws InputError if the file is not a scene.
void requireScene(const fs::path& file) {
  const Value root = readYaml(file);
  const FileKind kind = fileKind(root);
  if (kind == FileKind::Scene) return;
  if (kind == FileKind::Pipeline) {
    throw InputError({file.string()},
                     "is a pipeline: `scanmill generate {} -o DIR` makes the dataset that can be viewed",
                     file.string());
  }
  expectKind(root, FileKind::Scene);
  throw InputError({file.string()}, "is no scene: that has a list of `objects`");
}

std::unique_ptr<FrameSource> openScene(const ViewInput& input) {
  if (!input.over.empty() || !input.reference.empty() || !input.sensor.empty() || !input.scene.empty()) {
    throw InputError({input.path.string()},
                     "is a scene: --over, --reference, --sensor and --scene belong to a dataset, a shard or a scan");
  }
  requireScene(input.path);
  return std::make_unique<OneFrame>(
      ViewFrame{.key = input.path.filename().string(), .scans = {}, .problems = {}},
      SceneChoice{.file = input.path, .seed = input.seed.value_or(1), .ontology = input.ontology},
      input.ontology.empty() ? readSceneOntology(input.path) : readOntology(input.ontology));
}

}  // namespace

std::unique_ptr<FrameSource> openFrames(const ViewInput& input) {
  const std::string suffix = input.path.extension().string();
  const bool inputIsFile = isFile(input.path);
  if (inputIsFile && (suffix == ".yaml" || suffix == ".yml")) return openScene(input);
  if (input.seed && input.scene.empty() && pathExists(input.path)) {
    throw InputError({input.path.string()},
                     "is no scene: --seed is for a scene that is viewed by itself, or by --scene");
  }
  if (inputIsFile && suffix == ".exr") {
    throw InputError({input.path.string()}, "is an image of passes or hits, not a scan: it is viewed by itself");
  }
  if (inputIsFile && suffix != ".tar" && !isScan(input.path)) {
    throw InputError(
        {input.path.string()},
        "is neither a dataset's folder nor a shard or scan (.tar, {}) nor a scene (.yaml); of a model, `scanmill "
        "draft` makes a scene",
        scanSuffixes());
  }
  if (!input.scene.empty()) requireScene(input.scene);
  return std::make_unique<StoredFrames>(input);
}

}  // namespace scanmill
