// Writes manifests and the members that describe samples as JSON text, with keys in a fixed order and numbers that read
// back to the same bits, so that the bytes are always the same.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/hash.h"
#include "config/text.h"
#include "dataset/json_text.h"
#include "dataset/manifest.h"
#include "dataset/sample_names.h"

namespace scanmill {

namespace {

constexpr std::string_view kNoDigest = "0000000000000000000000000000000000000000000000000000000000000000";

// Returns the JSON of a scan; with the names of the classes if `ontology` is not null.
OrderedJson scanJson(const ScanRecord& scan, const std::string& key, const Ontology* ontology) {
  if (scan.worldFromSensor.empty()) throw Error(fmt::format("{}: a scan of {} has no pose", key, scan.sensor));
  OrderedJson poses = OrderedJson::array();
  for (const Pose& pose : scan.worldFromSensor) poses.push_back(poseJson(pose, key + ": world_from_sensor"));
  OrderedJson classes = OrderedJson::array();
  for (const auto& [id, points] : scan.pointsPerClass) {
    OrderedJson entry = OrderedJson::object();
    entry["id"] = id;
    if (ontology != nullptr) entry["name"] = requireClass(id, key, *ontology).name;
    entry["points"] = points;
    classes.push_back(std::move(entry));
  }
  OrderedJson json{{"sensor", scan.sensor}};
  if (scan.revolution > 0) json["revolution"] = scan.revolution;
  json["method"] = scan.method;
  json["time"] = finite(scan.time, key + ": time");
  json["world_from_sensor"] = std::move(poses);
  if (scan.vehicleFromSensor) {
    json["vehicle_from_sensor"] = poseJson(*scan.vehicleFromSensor, key + ": vehicle_from_sensor");
  }
  json["beams"] = scan.beams;
  json["points"] = scan.points;
  if (scan.unresolved > 0) json["unresolved"] = scan.unresolved;
  json["instances"] = scan.instances;
  json["points_per_class"] = std::move(classes);
  for (const auto& [reason, beams] : scan.beamsPerReason) {
    const ReasonEntry* known = findReason(reason);
    if (known == nullptr) throw Error(fmt::format("{}: no reason has the value {}", key, reason));
    json["reasons"][std::string(known->name)] = beams;
  }
  return json;
}

OrderedJson framesJson(const Manifest& manifest) {
  return {
      {"sensor", "right-handed; x forward, y left, z up"},
      {"world", "right-handed; z up"},
      {"vehicle", "right-handed; x forward, y left, z up"},
      {"quaternion", "w, x, y, z; unit"},
      {"vehicle_from_sensor", "vehicle point = rotation * sensor point + translation"},
      {"world_from_sensor",
       "world point = rotation * sensor point + translation; the first pose is at the start of the revolution, a "
       "second one "
       "at its end"},
      {"points", manifest.deskewed ? "in the sensor's frame at the start of the revolution"
                                   : "in the sensor's frame at the time of their own column"},
      {"ring", "0 to rings - 1, in the order of the sensor's elevation list; top_down: ring 0 is the highest"},
      {"azimuth", "from x towards y (counter-clockwise seen from above), whatever way the sensor turns"},
      {"column",
       "column 0 fires first; the head's azimuth t = first_azimuth +- field * swept (minus where clockwise), where "
       "swept is column / columns in a full revolution (field 2 pi), column / (columns - 1) in a smaller field, and "
       "0.5 in a "
       "smaller field of one column"},
      {"beam",
       "index ring * columns + column; direction (cos(t + a) cos e, sin(t + a) cos e, sin e) with a = "
       "azimuth_offset[ring] and e = elevation[ring]; origin (origin_offset cos t, origin_offset sin t, "
       "origin_height), and where the sensor has them origin_left[ring] (-sin(t + a), cos(t + a), 0) + "
       "origin_up[ring] (-cos(t + a) sin e, -sin(t + a) sin e, cos e) besides. Where the sensor has `beams`, their own "
       "azimuth, elevation, time and origin (x, y, z, x, ...). Where it has a `rosette`, deflected from x by the "
       "sum of all angle[k], each towards the angle speed[k] * (time of the scan + time of the beam) + phase[k] from y "
       "to "
       "z, and of left[ring] towards y and up[ring] towards z; where the rosette has a `mirror`, deflected from z "
       "towards x and "
       "y in place of y and z, and reflected by a mirror whose normal has the elevation tilt - pi / 2 and the azimuth "
       "speed * time + phase"},
      {"time",
       "scans: since the start of the sequence, of column 0; points: since the start of the revolution, period * field "
       "/ (2 pi) * swept + firing_offset[ring], where swept is that of `column`; where the sensor has a `sweep`, sweep "
       "* "
       "swept + firing_offset[ring]"},
  };
}

OrderedJson sensorJson(const SensorRecord& sensor) {
  const BeamTable& b = sensor.beams;
  for (const std::vector<double>* table : {&b.elevation, &b.azimuthOffset, &b.firingOffset}) {
    if (table->size() != b.rings) {
      throw Error(fmt::format("sensor {}: a table of {} entries for {} rings", sensor.name, table->size(), b.rings));
    }
  }
  const auto number = [&](double value, std::string_view what) {
    return finite(value, sensor.name + ": " + what.data());
  };
  OrderedJson json{{"name", sensor.name},
                   {"model", b.model},
                   {"source", b.source},
                   {"rings", b.rings},
                   {"columns", b.columns},
                   {"period", number(b.period, "period")},
                   {"clockwise", b.clockwise},
                   {"top_down", b.topDown},
                   {"min_range", number(b.minRange, "min_range")},
                   {"max_range", number(b.maxRange, "max_range")},
                   {"first_azimuth", number(b.firstAzimuth, "first_azimuth")},
                   {"field", number(b.field, "field")},
                   {"origin_offset", number(b.originOffset, "origin_offset")},
                   {"origin_height", number(b.originHeight, "origin_height")},
                   {"elevation", finiteList(b.elevation, sensor.name + ": elevation")},
                   {"azimuth_offset", finiteList(b.azimuthOffset, sensor.name + ": azimuth_offset")},
                   {"firing_offset", finiteList(b.firingOffset, sensor.name + ": firing_offset")}};
  if (sensor.vehicleFromSensor) {
    json["vehicle_from_sensor"] = poseJson(*sensor.vehicleFromSensor, sensor.name + ": vehicle_from_sensor");
  }
  if (b.listed != nullptr) {
    const auto list = [&](const std::vector<double>& values, const char* what) {
      return finiteList(values, fmt::format("{}: beams.{}", sensor.name, what));
    };
    json["beams"] = {{"azimuth", list(b.listed->azimuth, "azimuth")},
                     {"elevation", list(b.listed->elevation, "elevation")},
                     {"time", list(b.listed->time, "time")}};
    if (!b.listed->origin.empty()) {
      std::vector<double> origin;
      for (const Vec3f& o : b.listed->origin) origin.insert(origin.end(), {double{o.x}, double{o.y}, double{o.z}});
      json["beams"]["origin"] = list(origin, "origin");
    }
  }
  if (b.rosette) {
    const Rosette& r = *b.rosette;
    json["rosette"] = {{"angle", r.angle}, {"speed", r.speed}, {"phase", r.phase}};
    if (!r.left.empty()) json["rosette"].update({{"left", r.left}, {"up", r.up}});
    if (r.mirror) {
      json["rosette"]["mirror"] = {{"tilt", r.mirror->tilt}, {"speed", r.mirror->speed}, {"phase", r.mirror->phase}};
    }
  }
  if (b.sweep > 0) json["sweep"] = number(b.sweep, "sweep");
  if (sensor.intensityFullScale != 1)
    json["intensity_full_scale"] = number(sensor.intensityFullScale, "intensity_full_scale");
  if (!b.originLeft.empty()) json["origin_left"] = finiteList(b.originLeft, sensor.name + ": origin_left");
  if (!b.originUp.empty()) json["origin_up"] = finiteList(b.originUp, sensor.name + ": origin_up");
  return json;
}

template <class Records, class Make>
OrderedJson listOf(const Records& records, const Make& make) {
  OrderedJson list = OrderedJson::array();
  for (const auto& record : records) list.push_back(make(record));
  return list;
}

OrderedJson sequenceJson(const SequenceRecord& s) {
  OrderedJson json{
      {"name", s.name}, {"scene", s.scene}, {"seed", s.seed}, {"trajectory", s.trajectory}, {"moving", s.moving}};
  if (!s.sceneFile.empty()) json["scene_file"] = s.sceneFile;
  if (!s.vehicle.empty()) json["vehicle"] = s.vehicle;
  return json;
}

void addDraws(const SampleRecord& sample, OrderedJson& json) {
  for (const DrawnValue& draw : sample.draws) {
    json["draws"][draw.key] = draw.number ? OrderedJson::parse(draw.value) : OrderedJson(draw.value);
  }
}

OrderedJson sampleEntry(const SampleRecord& s, const Manifest& m) {
  OrderedJson sample{{"key", s.key}, {"split", s.split}, {"shard", s.shard}, {"members", s.members}};
  if (!s.xxh3.empty()) sample["xxh3"] = s.xxh3;
  sample["scans"] = listOf(s.scans, [&](const ScanRecord& scan) { return scanJson(scan, s.key, &m.ontology); });
  if (s.objects) {
    sample["objects"] = listOf(*s.objects, [&](const auto& entry) {
      const auto& [id, count] = entry;
      return OrderedJson{{"id", id},
                         {"name", requireClass(id, s.key, m.ontology).name},
                         {"objects", count.objects},
                         {"with_points", count.withPoints}};
    });
  }
  addDraws(s, sample);
  if (s.time) sample["time"] = finite(*s.time, s.key + ": time");
  return sample;
}

bool describesInFiles(const Manifest& m) {
  return std::any_of(m.shards.begin(), m.shards.end(),
                     [](const ShardRecord& shard) { return !shard.samplesSha256.empty(); });
}

// Returns the JSON of the manifest without its samples.
OrderedJson manifestJson(const Manifest& m) {
  OrderedJson json{
      {"schema_version", Manifest::kSchemaVersion},
      {"program", {{"name", "scanmill"}, {"version", m.programVersion}}},
      {"name", m.name},
      {"seed", m.seed},
      {"pipeline", {{"sha256", m.pipelineSha256}, {"text", m.pipelineText}}},
      {"units", {{"length", "metres"}, {"time", "seconds"}, {"angle", "radians"}}},
      {"frames", framesJson(m)},
      {"scans", {{"organised", m.organised}, {"deskewed", m.deskewed}, {"columns", m.columns}}},
      {"formats", listOf(m.formats,
                         [](const FormatRecord& f) {
                           return OrderedJson{{"name", f.name},
                                              {"suffix", f.suffix},
                                              {"max_error", finite(f.maxErrorMetres, "max_error of " + f.name)}};
                         })},
      {"ontology", ontologyJson(m.ontology)},
      {"sensors", listOf(m.sensors, sensorJson)},
      {"sequences", listOf(m.sequences, sequenceJson)},
      {"modelled", modelledJson(m.modelled)},
      {"files", listOf(m.files,
                       [](const FileRecord& f) {
                         return OrderedJson{{"file", f.file}, {"xxh3", f.xxh3}};
                       })},
      {"shards", listOf(m.shards,
                        [](const ShardRecord& s) {
                          OrderedJson shard{{"file", s.file},
                                            {"split", s.split},
                                            {"sha256", s.sha256},
                                            {"bytes", s.bytes},
                                            {"samples", s.samples}};
                          if (!s.samplesSha256.empty()) shard["samples_sha256"] = s.samplesSha256;
                          return shard;
                        })},
      {"samples", nullptr},
  };
  if (!m.about.empty()) json["about"] = m.about;
  if (!m.planSha256.empty()) json["plan_sha256"] = m.planSha256;
  json["digest"] = kNoDigest;
  return json;
}

OrderedJson sampleObject(const SampleRecord& sample) {
  const KeyParts parts = partsOfKey(sample.key);
  OrderedJson json{{"key", sample.key}, {"sequence", parts.sequence}, {"frame", parts.frame}, {"split", sample.split}};
  if (!sample.scans.empty()) {
    json["time"] = finite(sample.time.value_or(sample.scans.front().time), sample.key + ": time");
  }
  json["scans"] = listOf(sample.scans, [&](const ScanRecord& scan) { return scanJson(scan, sample.key, nullptr); });
  addDraws(sample, json);
  return json;
}

}  // namespace

std::string toJson(const Manifest& manifest) {
  std::string text = layOut(manifestJson(manifest), 0) + "\n";
  // Samples are converted to text one by one: the JSON objects of all samples would take ten times as much memory as
  // their text.
  std::vector<std::string> samples;
  if (!describesInFiles(manifest)) {
    samples.reserve(manifest.samples.size());
    for (const SampleRecord& sample : manifest.samples) samples.push_back(layOut(sampleEntry(sample, manifest), 2));
  }
  constexpr std::string_view kPlace = "\n \"samples\": null";  // occurs once, since JSON strings escape line breaks
  text.replace(text.rfind(kPlace) + kPlace.size() - 4, 4, layOutList(samples, 1));
  text.replace(text.rfind(kNoDigest), kNoDigest.size(), sha256(text));
  return text;
}

std::string samplesFileOf(const std::string& shardFile) {
  return std::filesystem::path(shardFile).replace_extension(".json").generic_string();
}

std::string samplesJson(const Manifest& manifest, std::uint32_t shard, const std::vector<std::uint64_t>& numbers) {
  OrderedJson samples = OrderedJson::array();
  for (const std::uint64_t number : numbers) samples.push_back(sampleEntry(manifest.samples[number], manifest));
  return layOut({{"shard", manifest.shards[shard].file}, {"numbers", numbers}, {"samples", samples}}) + "\n";
}

std::string digestProblem(std::string text) {
  constexpr std::string_view kKey = "\"digest\": \"";
  const std::size_t key = text.rfind(kKey);
  if (key == std::string::npos) return "has no digest, so that changes of it cannot be detected";
  const std::string stated = text.substr(key + kKey.size(), kNoDigest.size());
  text.replace(key + kKey.size(), stated.size(), kNoDigest);
  const std::string found = sha256(text);
  if (found == stated) return {};
  return fmt::format(
      "was changed since it was written: its digest is {}, but it states {}; `scanmill generate PIPELINE --overwrite` "
      "makes the dataset again",
      found, stated);
}

void expectUnchanged(const std::filesystem::path& file, const std::string& text) {
  const std::string problem = digestProblem(text);
  if (problem.starts_with("was changed")) throw InputError({file.string()}, problem);
}

std::string sampleJson(const SampleRecord& sample) {
  return layOut(sampleObject(sample), 0) + "\n";
}

std::string differenceOfSampleJson(std::string_view text, const SampleRecord& sample) {
  if (text == sampleJson(sample)) return {};
  const OrderedJson found = OrderedJson::parse(text, nullptr, false);
  if (found.is_discarded()) return "is not valid JSON";
  const OrderedJson expected = sampleObject(sample);
  const OrderedJson changes = OrderedJson::diff(expected, found);
  if (changes.empty()) return {};
  std::string place = changes[0]["path"].get<std::string>();
  const std::string operation = changes[0]["op"].get<std::string>();
  if (place.ends_with("/-"))
    return fmt::format("{} has more entries than the manifest says", place.erase(place.size() - 2));
  if (operation == "remove") return fmt::format("{} is missing", place);
  if (operation == "add") return fmt::format("{} is not in the manifest", place);
  return fmt::format("{} is {}, not {}", place, scalarText(changes[0]["value"]),
                     scalarText(expected[OrderedJson::json_pointer(place)]));
}

std::string SampleRecord::xxh3Of(const std::string& member) const {
  const auto place = static_cast<std::size_t>(std::find(members.begin(), members.end(), member) - members.begin());
  return place < xxh3.size() ? xxh3[place] : std::string();
}

const SequenceRecord* Manifest::sequenceOf(const std::string& key) const {
  const std::string own = partsOfKey(key).sequence;
  const auto found =
      std::find_if(sequences.begin(), sequences.end(), [&](const SequenceRecord& s) { return s.name == own; });
  return found == sequences.end() ? nullptr : &*found;
}

std::string memberSuffix(const ScanRecord& scan, std::string_view formatSuffix) {
  const std::string revolution = scan.revolution == 0 ? "" : fmt::format(".{}", scan.revolution);
  return lowerCase(fmt::format("{}{}.{}.{}", scan.sensor, revolution, scan.method, formatSuffix));
}

}  // namespace scanmill
