#include "viewer/frames/scene_lookup.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/error.h"
#include "config/fields.h"
#include "config/file_kind.h"
#include "config/resources.h"
#include "config/value.h"
#include "pipeline/plan/dataset_plan.h"
#include "pipeline/read/sequences.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

Value pipelineOf(const std::string& pipelineText, const fs::path& datasetFolder) {
  Value root = parseYaml(pipelineText, "the pipeline in " + (datasetFolder / "manifest.json").string());
  for (const std::string& assignment : overridesIn(pipelineText)) setValue(root, assignment);
  return root;
}

bool hasSeed(const Value& entry, std::uint64_t seed) {
  const Value* seeds = entry.find("seeds");
  if (seeds == nullptr || seeds->kind == Value::Kind::Null) return seed == 1;
  if (seeds->kind == Value::Kind::Scalar) return seeds->text == std::to_string(seed);
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const std::vector<PlacedInteger> all = readIntegers(*seeds, "seeds", 0, kMost);
  return std::ranges::any_of(all, [&](const PlacedInteger& s) { return s.value == static_cast<std::int64_t>(seed); });
}

// Returns the seed in a key that starts with the scene's name; nothing if the key does not have this form.
std::optional<std::uint64_t> seedBehind(const std::string& key, const std::string& scene) {
  if (!key.starts_with(scene + "-s")) return std::nullopt;
  const std::size_t begin = scene.size() + 2;
  const std::size_t end = key.find_first_not_of("0123456789", begin);
  if (end == std::string::npos || end == begin || end - begin > 18 || key[end] != '-') return std::nullopt;
  return std::stoull(key.substr(begin, end - begin));
}

struct Entry {
  std::string file;  // path of the scene file as written in the pipeline
  std::uint64_t seed = 1;
  bool moving = true;
};

// Returns the entry of the pipeline's `scenes` whose name and seed the key starts with; nothing if there is none. If
// two entries match ("town" and "town-s1-old"), returns the one with the longer name.
std::optional<Entry> entryOf(const Value& root, const std::string& key) {
  const Value* scenes = root.find("scenes");
  std::optional<Entry> best;
  std::size_t bestLength = 0;
  if (scenes == nullptr) return best;
  for (const Value& entry : scenes->items) {
    const Value* file = entry.find("scene");
    if (file == nullptr) continue;
    const fs::path name = fs::path(file->text).filename();
    // Keys may contain the scene's name without or with ".yaml".
    for (const std::string& scene : {keyPart(name.stem().string()), keyPart(name.string())}) {
      const auto seed = seedBehind(key, scene);
      if (!seed || !hasSeed(entry, *seed) || scene.size() < bestLength) continue;
      const Value* moving = entry.find("moving");
      best = {file->text, *seed, moving == nullptr || moving->text != "false"};
      bestLength = scene.size();
    }
  }
  return best;
}

std::optional<fs::path> fileNamed(const std::string& name, const fs::path& datasetFolder) {
  for (const fs::path& folder : pipelineFolders(datasetFolder)) {
    for (const std::string& written : {name, name + ".yaml"}) {
      const fs::path file = (folder / written).lexically_normal();
      std::error_code ignored;
      if (fs::is_regular_file(file, ignored)) return file;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<SceneChoice> sceneOfSample(const std::string& pipelineText, const fs::path& datasetFolder,
                                         const std::string& key, double time, std::string& why) {
  constexpr const char* kAdvice = "give --scene FILE to see it";
  try {
    const auto entry = entryOf(pipelineOf(pipelineText, datasetFolder), key);
    if (!entry) {
      why = fmt::format("the dataset's pipeline names no scene that '{}' was made of: {}", key, kAdvice);
      return std::nullopt;
    }
    const auto file = fileNamed(entry->file, datasetFolder);
    if (file) return SceneChoice{*file, entry->seed, entry->moving ? time : 0};
    why = fmt::format("the scene '{}' of the dataset's pipeline is not found here: {}", entry->file, kAdvice);
  } catch (const InputError& e) {
    why = fmt::format("{}: {}", e.what(), kAdvice);
  }
  return std::nullopt;
}

std::optional<fs::path> vehicleOf(const std::string& pipelineText, const fs::path& datasetFolder) {
  try {
    const Value root = pipelineOf(pipelineText, datasetFolder);
    const Value* vehicle = root.find("vehicle");
    if (vehicle != nullptr && vehicle->kind == Value::Kind::Map) vehicle = vehicle->find("scene");
    if (vehicle == nullptr || vehicle->kind != Value::Kind::Scalar) return {};
    const auto file = fileNamed(vehicle->text, datasetFolder);
    return file ? file : fileNamed((resourceFolder() / "scenes" / vehicle->text).string(), datasetFolder);
  } catch (const InputError&) {
    return {};
  }
}

std::uint64_t seedOfKey(const std::string& key) {
  for (std::size_t at = key.find("-s"); at != std::string::npos; at = key.find("-s", at + 1)) {
    if (const auto seed = seedBehind(key, key.substr(0, at))) return *seed;
  }
  return 1;
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
