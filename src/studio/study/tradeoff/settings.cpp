#include <fmt/core.h>

#include <algorithm>

#include "config/fields.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

// Settings (YAML) that a study measures if the pipeline lists none, in addition to each method with default options.
constexpr const char* kDefaultSettings = R"(
- {ray_tracing: {simplify: [0.5, 0.25, 0.1]}}
- {depth_camera: {resolution: [512, 1024]}}
- {depth_camera: {sampling: nearest}}
- {particle: {refine: none}}
- {particle: {refine: none, voxel_m: 0.2}}
- {particle: {refine: none, voxels: 512}}
- {particle: {refine: none, levels: 3}}
- {particle: {backend: gl, refine: [triangle, none]}}
- {depth_camera: {depth: [uint24, uint16]}}
- {depth_camera: {layout: three_120}}
- {depth_camera: {layout: three_120, sampling: nearest, depth: half_500}}
- {depth_camera: {sampling: nearest, resolution: 512}}
- {particle: {levels: 1, voxel_m: 1, refine: none}}
- {depth_camera: {resolution: 4096}}
)";

constexpr const char* kDefaultEncodings = R"(
- {pcd: {encoding: [binary_compressed, binary]}}
- {draco: {max_error_mm: [0.1, 1, 10, 50]}}
)";

std::vector<StudyEncoding> readEncodings(const Value& list) {
  std::vector<StudyEncoding> encodings;
  for (const Value& item : readList(list, "tradeoff.encodings")) {
    const NamedOptions named = readNamed(item, "an item of tradeoff.encodings");
    const FormatEntry& entry = requireFormat(named.name, named.where);
    for (const Value& options : expandLists(named.options, "tradeoff.encodings")) {
      Fields fields(options, "format " + named.name);
      fields.alsoDescribed(entry.keys).finish();
      StudyEncoding encoding{settingName(named.name, options), flowText(options), {&entry, entry.make(fields)}};
      if (std::ranges::find(encodings, encoding.name, &StudyEncoding::name) != encodings.end())
        throw InputError(item.where, "tradeoff.encodings: '{}' is listed twice", encoding.name);
      encodings.push_back(std::move(encoding));
    }
  }
  return encodings;
}

std::size_t readSequence(const Value& value, const Pipeline& pipeline) {
  const std::string key = readText(value, "tradeoff.sequence");
  std::vector<std::string> keys;
  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    keys.push_back(pipeline.sequences[s].key());
    if (keys.back() == key) return s;
  }
  throw InputError(value.where, "tradeoff.sequence: the pipeline has no sequence '{}'{}", key, suggestion(key, keys));
}

}  // namespace

std::vector<MethodSetting> defaultSettings() {
  std::string list;
  for (const MethodEntry& method : methods()) list += fmt::format("- {}\n", method.name);
  return readSettings(parseYaml(list + kDefaultSettings, "default settings"), "settings");
}

StudyChoice readStudyChoice(const Pipeline& pipeline) {
  StudyChoice choice;
  Fields fields(pipeline.root.valueOf("tradeoff"), "tradeoff");
  fields.also({"settings", "encodings", "sequence", "shots", "repeats"}).finish();
  const Value* settings = fields.find("settings");
  choice.settings = settings == nullptr ? defaultSettings() : readSettings(*settings, "tradeoff.settings");
  const Value* encodings = fields.find("encodings");
  choice.encodings =
      readEncodings(encodings == nullptr ? parseYaml(kDefaultEncodings, "default encodings") : *encodings);
  if (const Value* sequence = fields.find("sequence")) choice.sequence = readSequence(*sequence, pipeline);
  choice.shots = static_cast<std::uint32_t>(fields.integer("shots", 1, 1000, 8));
  choice.repeats = static_cast<int>(fields.integer("repeats", 1, 100, 3));
  return choice;
}

}  // namespace scanmill
