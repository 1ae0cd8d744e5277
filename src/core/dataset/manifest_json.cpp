// Writes and reads manifests, the files beside the shards that describe the samples of large datasets, and the members
// that describe samples. Keys have a fixed order, and numbers read back to the same bits, so that the same records
// always give the same bytes.

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "config/text.h"
#include "dataset/folder_contents.h"
#include "dataset/json_record.h"
#include "dataset/manifest.h"
#include "dataset/names.h"

namespace scanmill {

namespace {

constexpr std::string_view kNoDigest = "0000000000000000000000000000000000000000000000000000000000000000";

// Returns explanations of the manifest's and the scans' frames, indices and times, for people who read the manifest.
OrderedJson framesJson(const Manifest& manifest) {
  return {
      {"sensor", "right-handed; x forward, y left, z up"},
      {"world", "right-handed; z up"},
      {"vehicle", "right-handed; x forward, y left, z up"},
      {"quaternion", "w, x, y, z; unit"},
      {"vehicle_from_sensor", "vehicle point = rotation * sensor point + translation"},
      {"world_from_sensor",
       "world point = rotation * sensor point + translation; the first pose is at the start of the revolution, a "
       "second one at its end"},
      {"points", manifest.deskewed ? "in the sensor's frame at the start of the revolution"
                                   : "in the sensor's frame at the time of their own column"},
      {"ring", "0 to rings - 1, in the order of the sensor's elevation list; top_down: ring 0 is the highest"},
      {"azimuth", "from x towards y (counter-clockwise seen from above), whatever way the sensor turns"},
      {"column",
       "column 0 fires first; the head's azimuth t = first_azimuth +- field * swept (minus where clockwise), where "
       "swept is column / columns in a full revolution (field 2 pi), column / (columns - 1) in a smaller field, and "
       "0.5 in a smaller field of one column"},
      {"beam",
       "index ring * columns + column; direction (cos(t + a) cos e, sin(t + a) cos e, sin e) with a = "
       "azimuth_offset[ring] and e = elevation[ring]; origin (origin_offset cos t, origin_offset sin t, "
       "origin_height), and where the sensor has them origin_left[ring] (-sin(t + a), cos(t + a), 0) + "
       "origin_up[ring] (-cos(t + a) sin e, -sin(t + a) sin e, cos e) besides. Where the sensor has `beams`, their "
       "own azimuth, elevation, time and origin (x, y, z, x, ...). Where it has a `rosette`, deflected from x by the "
       "sum of all angle[k], each towards the angle speed[k] * (time of the scan + time of the beam) + phase[k] from "
       "y to z, and of left[ring] towards y and up[ring] towards z; where the rosette has a `mirror`, deflected from "
       "z towards x and y in place of y and z, and reflected by a mirror whose normal has the elevation tilt - pi / 2 "
       "and the azimuth speed * time + phase"},
      {"time",
       "scans: since the start of the sequence, of column 0; points: since the start of the revolution, period * "
       "field / (2 pi) * swept + firing_offset[ring], where swept is that of `column`; where the sensor has a "
       "`sweep`, sweep * swept + firing_offset[ring]"},
  };
}

// Returns the text of a file that describes the samples of a shard. Throws InputError if the file is unreadable or its
// SHA-256 does not match `shard`. Also refuses a file of more than about four times the shard's bytes without reading
// it: a shard contains the descriptions, too, so that such a file cannot be genuine.
std::string readSamplesText(const std::filesystem::path& file, const ShardRecord& shard) {
  constexpr std::uint64_t kAlwaysRead = 1 << 20;  // bytes added to the shard's, so that files of small shards are read
  std::error_code unreadable;                     // readFile() reports the reason
  const std::uint64_t bytes = std::filesystem::file_size(file, unreadable);
  const bool plausible = unreadable || bytes / 4 <= kAlwaysRead + shard.bytes;
  std::string text = plausible ? readFile(file) : std::string();
  if (sha256(text) == shard.samplesSha256) return text;
  throw InputError({file.string()}, "was changed since it was written: its SHA-256 differs from the manifest");
}

// Parses the text that describes the samples of the shard with the index `shardIndex`. Stores each sample in `samples`,
// which has the size of the complete dataset, at the index that the text states for the sample.
void parseSamples(const std::string& text, const std::filesystem::path& folder, std::uint32_t shardIndex,
                  const Manifest& head, std::vector<SampleRecord>& samples) {
  const ShardRecord& shard = head.shards[shardIndex];
  const std::string file = (folder / samplesFileOf(shard.file)).string();
  const Json json = parseJson(text, file);
  const JsonNode root(json, "", file);
  root.keys({"shard", "numbers", "samples"});
  std::vector<std::uint64_t> indices;  // indices of the text's samples among all samples
  root["numbers"].forEach([&](const JsonNode& item) {
    indices.push_back(item.integer<std::uint64_t>());
    if (indices.back() >= samples.size()) item.fail("is not below {}, the number of samples", samples.size());
  });
  std::size_t readCount = 0;
  root["samples"].forEach([&](const JsonNode& item) {
    SampleRecord sample;
    readJson(item, sample, {&head.ontology, &head});
    if (sample.shard != shardIndex) item["shard"].fail("is not {}, the number of {}", shardIndex, shard.file);
    if (readCount >= indices.size() || !samples[indices[readCount]].key.empty())
      item.fail("has no number, or the number of another sample");
    samples[indices[readCount++]] = std::move(sample);
  });
  if (readCount != shard.samples) root["samples"].fail("has {} entries, not {}", readCount, shard.samples);
}

// Returns true if files beside the shards describe the samples, not the manifest itself.
bool hasSamplesFiles(const Manifest& manifest) {
  return std::ranges::any_of(manifest.shards, [](const ShardRecord& shard) { return !shard.samplesSha256.empty(); });
}

// Reads the samples from the files beside the shards, and returns the manifest with them. If a file is missing or
// damaged, stores a message in `undescribed`, see readManifest().
Manifest withSamplesOfFiles(Manifest manifest, const std::filesystem::path& folder,
                            std::map<std::uint32_t, std::string>& undescribed) {
  if (!hasSamplesFiles(manifest)) return manifest;
  const std::filesystem::path file = folder / kManifestName;
  constexpr std::uint64_t kMostSamples = 10'000'000;  // their records take 2 GB of memory
  std::uint64_t sampleCount = 0;
  for (const ShardRecord& shard : manifest.shards) {
    sampleCount += std::min(shard.samples, kMostSamples + 1);
    if (sampleCount > kMostSamples) throw InputError({file.string()}, "states more than {} samples", kMostSamples);
  }
  std::vector<SampleRecord> samples(sampleCount);
  for (std::uint32_t shard = 0; shard < manifest.shards.size(); ++shard) {
    const ShardRecord& record = manifest.shards[shard];
    std::string text;
    try {
      text = readSamplesText(folder / samplesFileOf(record.file), record);
    } catch (const InputError& error) {
      undescribed[shard] = error.what();
      continue;
    }
    parseSamples(text, folder, shard, manifest, samples);
  }
  std::set<std::string_view> keys;
  for (const SampleRecord& sample : samples) {
    if (!sample.key.empty() && !keys.insert(sample.key).second) {
      throw InputError({file.string()}, "has two samples " + sample.key);
    }
  }
  manifest.samples = std::move(samples);
  return manifest;
}

// Returns the description of a sample for its member `<key>.json`, see sampleJson().
OrderedJson sampleObject(const SampleRecord& sample) {
  const KeyParts parts = partsOfKey(sample.key);
  OrderedJson json{{"key", sample.key}, {"sequence", parts.sequence}, {"frame", parts.frame}, {"split", sample.split}};
  if (!sample.scans.empty()) {
    json["time"] = finite(sample.time.value_or(sample.scans.front().time), sample.key + ": time");
  }
  json["scans"] = jsonOf(sample.scans, sample.key);
  if (OrderedJson draws = drawsJson(sample); !draws.is_discarded()) json["draws"] = std::move(draws);
  return json;
}

// Throws InputError unless the JSON is a manifest that this program wrote, in the present version. `root`: node of
// `json`.
void checkVersion(const JsonNode& root, const Json& json, const std::string& file) {
  const bool isManifest = json.is_object() && json.contains("schema_version") &&
                          json["schema_version"].is_number_integer() && json.contains("program") &&
                          json["program"].is_object() && json["program"].value("name", Json()) == "scanmill";
  if (!isManifest) throw InputError({file}, "is not a manifest of scanmill");
  const JsonNode version = root["schema_version"];
  const std::int64_t number = json["schema_version"].get<std::int64_t>();
  if (number > Manifest::kSchemaVersion) {
    version.fail("{} is newer than this program, which reads {}: update scanmill", number, Manifest::kSchemaVersion);
  }
  if (number < Manifest::kSchemaVersion) {
    version.fail(
        "{} is older than this program, which reads {}: make the dataset again with `scanmill generate PIPELINE -o "
        "FOLDER`, in a new folder",
        number, Manifest::kSchemaVersion);
  }
}

}  // namespace

// Describes the keys of the manifest. In writing, `samples` is null: toJson() replaces it by the samples. In reading,
// the order of the keys matters: `samples` needs the ontology, the sensors and the shards.
static void describe(RecordKeys& keys, Manifest& m) {
  int version = Manifest::kSchemaVersion;
  keys("schema_version", version);
  keys.map("program", [&](RecordKeys& program) {
    program.fixed("name", "scanmill");
    program("version", m.programVersion);
  });
  keys("name", m.name);
  keys("seed", m.seed);
  keys.map("pipeline", [&](RecordKeys& pipeline) {
    pipeline("sha256", m.pipelineSha256, kSha256Digits);
    pipeline("text", m.pipelineText);
  });
  keys.map("units", [](RecordKeys& units) {
    units.fixed("length", "metres");
    units.fixed("time", "seconds");
    units.fixed("angle", "radians");
  });
  keys.custom(
      "frames", [&] { return framesJson(m); },
      [](const JsonNode& node) {
        node.forEachEntry([](const std::string&, const JsonNode& meaning) { meaning.text(); });
      });
  keys.map("scans", [&](RecordKeys& scans) {
    scans("organised", m.organised);
    scans("deskewed", m.deskewed);
    scans("columns", m.columns);
    scans.optional("object_classes", m.objectClasses);
  });
  keys("formats", m.formats);
  keys("ontology", m.ontology);
  keys("sensors", m.sensors);
  keys("sequences", m.sequences);
  keys("modelled", m.modelled);
  keys("files", m.files);
  keys("shards", m.shards);
  keys.custom(
      "samples", [] { return OrderedJson(); },
      [&](const JsonNode& node) {
        readJson(node, m.samples, {&m.ontology, &m});
        distinct("key")(node);
      });
  keys.customOptional(
      "about", [&] { return m.about.empty() ? kAbsent : OrderedJson(m.about); },
      [&](const JsonNode& about) {
        about.keys({}, {"description", "license", "creator", "url", "citation"});
        about.forEachEntry([&](const std::string& key, const JsonNode& text) { m.about.emplace(key, text.text()); });
      });
  keys("plan_sha256", m.planSha256, kSha256Digits);
  keys.custom(
      "digest", [] { return OrderedJson(kNoDigest); }, kSha256Digits);
}

std::string toJson(const Manifest& manifest) {
  std::string text = layOut(jsonOf(manifest, manifest.name, {&manifest.ontology, &manifest})) + "\n";
  // Samples are converted to text one by one: the JSON objects of all samples would take ten times as much memory as
  // their text.
  std::vector<std::string> samples;
  if (!hasSamplesFiles(manifest)) {
    samples.reserve(manifest.samples.size());
    for (const SampleRecord& sample : manifest.samples) {
      samples.push_back(layOut(jsonOf(sample, sample.key, {&manifest.ontology, &manifest}), 2));
    }
  }
  constexpr std::string_view kKey = "\n \"samples\": ", kNull = "null";
  const std::size_t key = text.rfind(kKey);  // occurs once, since JSON strings escape line breaks
  text.replace(key + kKey.size(), kNull.size(), layOutList(samples, 1));
  text.replace(text.rfind(kNoDigest), kNoDigest.size(), sha256(text));
  return text;
}

std::string samplesFileOf(const std::string& shardFile) {
  return std::filesystem::path(shardFile).replace_extension(".json").generic_string();
}

std::string samplesJson(const Manifest& manifest, std::uint32_t shard, const std::vector<std::uint64_t>& numbers) {
  OrderedJson samples = OrderedJson::array();
  for (const std::uint64_t number : numbers) {
    const SampleRecord& sample = manifest.samples[number];
    samples.push_back(jsonOf(sample, sample.key, {&manifest.ontology, &manifest}));
  }
  return layOut({{"shard", manifest.shards[shard].file}, {"numbers", numbers}, {"samples", samples}}) + "\n";
}

Manifest parseManifest(const std::string& text, const std::string& file) {
  const Json json = parseJson(text, file);
  const JsonNode root(json, "", file);
  checkVersion(root, json, file);
  Manifest manifest;
  readJson(root, manifest);
  return manifest;
}

std::string digestProblem(std::string text) {
  constexpr std::string_view kKey = "\"digest\": \"";
  const std::size_t key = text.rfind(kKey);
  if (key == std::string::npos) return "has no digest, so that changes of it cannot be detected";
  const std::string stated = text.substr(key + kKey.size(), kNoDigest.size());
  text.replace(key + kKey.size(), stated.size(), kNoDigest);
  const std::string computed = sha256(text);
  if (computed == stated) return {};
  return fmt::format(
      "was changed since it was written: its digest is {}, but it states {}; `scanmill generate PIPELINE --overwrite` "
      "makes the dataset again",
      computed, stated);
}

void requireStatedDigest(const std::filesystem::path& file, const std::string& text) {
  const std::string problem = digestProblem(text);
  if (problem.starts_with("was changed")) throw InputError({file.string()}, problem);
}

std::string sampleJson(const SampleRecord& sample) {
  return layOut(sampleObject(sample), 0) + "\n";
}

std::string differenceOfSampleJson(std::string_view text, const SampleRecord& sample) {
  if (text == sampleJson(sample)) return {};
  const OrderedJson member = OrderedJson::parse(text, nullptr, false);
  if (member.is_discarded()) return "is not valid JSON";
  const OrderedJson expected = sampleObject(sample);
  const OrderedJson changes = OrderedJson::diff(expected, member);  // a JSON patch (RFC 6902)
  if (changes.empty()) return {};
  std::string path = changes[0]["path"].get<std::string>();
  const std::string operation = changes[0]["op"].get<std::string>();
  if (path.ends_with("/-"))
    return fmt::format("{} has more entries than the manifest says", path.erase(path.size() - 2));
  if (operation == "remove") return fmt::format("{} is missing", path);
  if (operation == "add") return fmt::format("{} is not in the manifest", path);
  return fmt::format("{} is {}, not {}", path, scalarText(changes[0]["value"]),
                     scalarText(expected[OrderedJson::json_pointer(path)]));
}

std::string SampleRecord::xxh3Of(const std::string& member) const {
  const auto index = static_cast<std::size_t>(std::ranges::find(members, member) - members.begin());
  return index < xxh3.size() ? xxh3[index] : std::string();
}

const SequenceRecord* Manifest::sequenceOf(const std::string& key) const {
  const auto found = std::ranges::find(sequences, partsOfKey(key).sequence, &SequenceRecord::name);
  return found == sequences.end() ? nullptr : &*found;
}

std::string memberSuffix(const ScanRecord& scan, std::string_view formatSuffix) {
  return lowerCase(fmt::format("{}.{}.{}", revolutionName(scan), scan.method, formatSuffix));
}

std::string revolutionName(const ScanRecord& scan) {
  return lowerCase(scan.sensor) + (scan.revolution == 0 ? "" : fmt::format(".{}", scan.revolution));
}

Manifest readManifest(const std::filesystem::path& folder) {
  std::map<std::uint32_t, std::string> undescribed;
  Manifest manifest = readManifest(folder, undescribed);
  if (undescribed.empty()) return manifest;
  const std::size_t others = undescribed.size() - 1;
  throw InputError(fmt::format(
      "{}{}\nnext: `scanmill verify {}` says how to make it again", undescribed.begin()->second,
      others == 0 ? "" : fmt::format(" (and so are {} more files that describe samples)", others), folder.string()));
}

Manifest readManifest(const std::filesystem::path& folder, std::map<std::uint32_t, std::string>& undescribed) {
  const std::filesystem::path file = folder / kManifestName;
  requireDataset(folder);
  const std::string text = readFile(file);
  try {
    return withSamplesOfFiles(parseManifest(text, file.string()), folder, undescribed);
  } catch (const InputError& error) {
    try {
      requireStatedDigest(file, text);
    } catch (const InputError& changed) {  // a changed manifest may be the cause of the error: report both
      throw InputError(fmt::format("{}; {}", changed.what(), error.what()));
    }
    throw;
  }
}

}  // namespace scanmill
