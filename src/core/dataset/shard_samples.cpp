#include "dataset/shard_samples.h"

#include <string>
#include <string_view>

#include "base/error.h"
#include "base/hash.h"
#include "dataset/json_node.h"
#include "dataset/json_text.h"
#include "dataset/objects.h"
#include "dataset/reader.h"
#include "dataset/sample_names.h"

namespace scanmill {

namespace {

// Returns the record that the text of a member `<key>.json` states, without members and counts of objects. The text has
// the ids of classes, and the manifest also their names.
SampleRecord statedRecord(std::string_view text, const std::string& member, std::uint32_t shard,
                          const Manifest& manifest) {
  Json json = parseJson(std::string(text), member);
  try {
    for (const char* const derived : {"sequence", "frame", "time"}) json.erase(derived);
    json["shard"] = shard;
    json["members"] = Json::array();
    for (Json& scan : json.at("scans")) {
      for (Json& entry : scan.at("points_per_class")) {
        entry["name"] = requireClass(entry.at("id").get<std::uint16_t>(), member, manifest.ontology).name;
      }
    }
  } catch (const Json::exception& error) {
    throw InputError({member}, fmt::format("does not describe a sample: {}", error.what()));
  }
  return sampleOf(JsonNode(json, "", member), manifest);
}

}  // namespace

std::vector<SampleRecord> samplesOfShard(const std::filesystem::path& folder, const Manifest& manifest,
                                         std::uint32_t shard) {
  std::vector<SampleRecord> samples;
  readTar(folder / manifest.shards[shard].file, [&](const std::string& name, std::string_view bytes) {
    const std::string key = partsOfMember(name).key;
    // The first member of a sample is `<key>.json`.
    if (samples.empty() || samples.back().key != key) samples.push_back(statedRecord(bytes, name, shard, manifest));
    SampleRecord& sample = samples.back();
    if (name == objectsMember(key)) sample.objects = parseObjects(bytes, name, manifest.ontology).counts();
    sample.members.push_back(name);
    sample.xxh3.push_back(xxh3(bytes));
  });
  return samples;
}

}  // namespace scanmill
