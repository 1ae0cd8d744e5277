#include "dataset/parts.h"

#include <algorithm>
#include <optional>
#include <set>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "dataset/dataset_folder.h"
#include "dataset/folder_contents.h"
#include "dataset/json_record.h"
#include "dataset/names.h"

namespace scanmill {

std::vector<std::string> DatasetPlan::shards() const {
  std::vector<std::string> names;
  for (const auto& [split, count] : splits) {
    for (std::uint64_t i = 0; i < count; ++i) names.push_back(shardName(split, i));
  }
  return names;
}

static void describe(RecordKeys& keys, DatasetPlan::Split& split) {
  keys("split", split.name, [&](const JsonNode& node) {
    if (!isSplitName(split.name)) node.fail("is not a name of a split");
  });
  keys("shards", split.shards);
}

static void describe(RecordKeys& keys, DatasetPlan& plan) {
  keys("plan", plan.hash);
  keys("samples", plan.samples);
  keys("splits", plan.splits);
}

// Describes the first line of a part's text. The other lines are the part's manifest, which has a digest of its own.
static void describe(RecordKeys& keys, DatasetPart& part) {
  keys("plan", part.plan);
  keys("numbers", part.numbers);
  keys.optional("placed", part.placed);
}

std::string toJson(const DatasetPlan& plan) {
  return layOut(jsonOf(plan, "plan")) + "\n";
}

DatasetPlan parsePlan(const std::string& text, const std::string& file) {
  const Json json = parseJson(text, file);
  DatasetPlan plan;
  readJson(JsonNode(json, "", file), plan);
  return plan;
}

std::string toJson(const DatasetPart& part) {
  return jsonOf(part, "part").dump() + "\n" + toJson(part.manifest);
}

DatasetPart parsePart(const std::string& text, const std::string& file) {
  const std::size_t firstLineEnd = std::min(text.find('\n'), text.size());
  const std::string manifest = text.substr(std::min(firstLineEnd + 1, text.size()));
  const Json json = parseJson(text.substr(0, firstLineEnd), file);
  DatasetPart part;
  readJson(JsonNode(json, "", file), part);
  part.manifest = parseManifest(manifest, file);
  if (const std::string problem = digestProblem(manifest); !problem.empty()) throw InputError({file}, problem);
  if (part.manifest.shards.size() != 1 || part.manifest.samples.size() != part.numbers.size()) {
    throw InputError({file}, "must have exactly one shard with all its samples");
  }
  return part;
}

// Moves the samples of `part` into joined.samples, where an empty record is reserved for each sample of the plan. The
// last shard in `joined` must be the part's shard. Throws Error if an index is out of range or already has a sample.
static void moveSamples(DatasetPart& part, Manifest& joined) {
  const auto shardIndex = static_cast<std::uint32_t>(joined.shards.size() - 1);
  const std::string& shardFile = joined.shards[shardIndex].file;
  for (std::size_t i = 0; i < part.numbers.size(); ++i) {
    const std::uint64_t sampleIndex = part.numbers[i];
    if (sampleIndex >= joined.samples.size()) {
      throw Error("{}: sample {} is out of range: the plan has {} samples", shardFile, sampleIndex,
                  joined.samples.size());
    }
    SampleRecord& sample = joined.samples[sampleIndex];
    if (!sample.key.empty()) {
      throw Error("sample {} is in two shards, {} and {}", sample.key, joined.shards[sample.shard].file, shardFile);
    }
    sample = std::move(part.manifest.samples[i]);
    sample.shard = shardIndex;
  }
}

Manifest joinParts(const DatasetPlan& plan, std::vector<DatasetPart> parts, bool anyFiles) {
  if (parts.empty()) throw Error("a dataset must have at least one shard");
  Manifest joined = parts.front().manifest;
  joined.shards.clear();
  joined.sequences.clear();
  std::set<std::string> sequenceNames;
  joined.samples.assign(plan.samples, {});
  for (DatasetPart& datasetPart : parts) {
    const Manifest& part = datasetPart.manifest;
    joined.shards.push_back(part.shards[0]);
    for (const SequenceRecord& sequence : part.sequences) {
      if (sequenceNames.insert(sequence.name).second) joined.sequences.push_back(sequence);
    }
    addItems(part.modelled, joined.modelled);
    const std::string changed = addFiles(part.files, joined.files);
    if (!changed.empty() && !anyFiles) {
      throw Error(
          "{} changed while the dataset was made, so that its shards are of different scenes: start "
          "again with `generate --overwrite`, or complete it by `generate --resume=anyway`",
          changed);
    }
    moveSamples(datasetPart, joined);
  }
  for (std::size_t i = 0; i < joined.samples.size(); ++i) {
    if (joined.samples[i].key.empty()) throw Error("sample {} of {} is in no shard", i, plan.samples);
  }
  std::vector<std::string> allScenes;
  for (const ModelledItem& item : joined.modelled) appendNew(item.scenes, allScenes);
  for (ModelledItem& item : joined.modelled) {  // an empty list means all scenes
    if (item.scenes.size() == allScenes.size()) item.scenes.clear();
  }
  return joined;
}

Manifest mergeDataset(const std::filesystem::path& folder) {
  if (!isUnfinished(folder) && pathExists(folder / kManifestName)) {
    DatasetFolder::tidy(folder);
    return readManifest(folder);
  }
  const DatasetPlan plan = DatasetFolder::planned(folder);
  DatasetFolder opened(folder, FolderUse::Resume, plan);
  std::vector<DatasetPart> parts;
  std::vector<std::uint64_t> missing;  // numbers of shards
  const std::vector<std::string> names = plan.shards();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::optional<DatasetPart> part = opened.findRecord(names[i], DatasetFolder::Check::Size)) {
      parts.push_back(std::move(*part));
    } else {
      missing.push_back(i);
    }
  }
  if (!missing.empty()) {
    const std::string ranges = shardRanges(missing);
    throw InputError(
        {folder.string()},
        "{} of {} shards are missing or damaged: {}; make them by `scanmill generate PIPELINE -o {} --shards {}`",
        missing.size(), names.size(), ranges, folder.string(), ranges);
  }
  Manifest manifest = joinParts(plan, std::move(parts));
  opened.publish(manifest);
  return manifest;
}

}  // namespace scanmill
