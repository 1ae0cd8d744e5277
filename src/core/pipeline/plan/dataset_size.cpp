#include "pipeline/plan/dataset_size.h"

#include <algorithm>
#include <cmath>

#include "dataset/manifest.h"
#include "dataset/objects.h"
#include "dataset/sample_json.h"
#include "dataset/shard.h"
#include "dataset/voxels.h"
#include "formats/reasons_png.h"
#include "pipeline/plan/shard_jobs.h"

namespace scanmill {

namespace {

constexpr double kWidest = -1.2345678901234567e-100;  // no number of a pose has more digits
constexpr double kManifestNotes = 4096;               // what the method has modelled, stages, hashes
constexpr double kShardRecord = 300;                  // of the manifest
constexpr double kSeparators = 64;                    // a record within its list
constexpr std::uint64_t kUsualObjects = 1000;         // near the sensors of a sample, at most
constexpr double kReserve = 10;                       // m; with twice the range: noise, and the way of a revolution

double bytesOf(const std::string& text) {
  return static_cast<double>(text.size());
}

std::string longestMethodName() {
  std::string longest;
  for (const MethodEntry& m : methods()) longest = m.name.size() > longest.size() ? std::string(m.name) : longest;
  return longest;
}

// What a sample's list of so many objects takes.
double objectsBytes(const Plan& plan, std::uint64_t objects) {
  constexpr double kObject = 700;  // without its views; names are longer than this leaves for them but rarely
  constexpr double kView = 450;
  if (!plan.pipeline().objects) return 0;
  return static_cast<double>(objects) * (kObject + kView * static_cast<double>(plan.beams().size()));
}

// The sample whose descriptions are the longest: every beam meets every class, as often as it can.
SampleRecord longestSample(const Plan& plan, const Sequence& sequence, const Ontology& ontology) {
  const Pipeline& pipeline = plan.pipeline();
  const Pose pose{{kWidest, kWidest, kWidest, kWidest}, {kWidest, kWidest, kWidest}};
  const bool moves = pipeline.recording != nullptr || pipeline.motion.kind != MotionKind::None;
  SampleRecord sample;
  sample.key = sequence.key(sequence.frames);
  sample.split = sequence.split;
  sample.members.push_back(sample.key + ".json");
  if (pipeline.recording == nullptr) sample.draws = longestSceneDraws(sequence.sceneFile);
  if (pipeline.drawn != nullptr) {
    const std::vector<DrawnValue> more = pipeline.drawn->longestDraws();
    sample.draws.insert(sample.draws.end(), more.begin(), more.end());
  }
  for (std::size_t s = 0; s < plan.beams().size(); ++s) {
    ScanRecord scan;
    scan.sensor = pipeline.sensors[s].name;
    scan.method = pipeline.method.automatic ? longestMethodName() : pipeline.methodName();
    scan.time = kWidest;
    scan.worldFromSensor.assign(moves ? 2 : 1, pose);
    scan.beams = plan.beams()[s]->size();
    scan.points = scan.beams * pipeline.mostReturns();
    scan.instances = static_cast<std::uint32_t>(scan.points);
    if (pipeline.layout.columns.has(kLabel)) {
      for (const SemanticClass& c : ontology.classes) scan.pointsPerClass[c.id] = scan.points;
    }
    for (const FormatChoice& f : pipeline.formats) {
      sample.members.push_back(sample.key + "." + memberSuffix(scan, f.format->suffix()));
    }
    if (pipeline.objects) {
      std::map<std::uint16_t, ObjectCount>& counts = sample.objects.emplace();
      for (const SemanticClass& c : ontology.classes) counts[c.id] = {UINT32_MAX, UINT32_MAX};
    }
    if (pipeline.layout.reasons) {
      for (const ReasonEntry& r : reasons()) scan.beamsPerReason[static_cast<std::uint8_t>(r.reason)] = scan.beams;
      sample.members.push_back(sample.key + "." + memberSuffix(scan, kReasonsSuffix));
    }
    if (pipeline.voxels) sample.members.push_back(sample.key + "." + memberSuffix(scan, kVoxelsSuffix));
    if (pipeline.drawn != nullptr && pipeline.drawn->drawsMounts()) scan.vehicleFromSensor = pose;
    sample.scans.push_back(std::move(scan));
  }
  return sample;
}

// The scans of a frame in all formats, in the order of longestSample()'s members.
std::vector<double> scanBytes(const Plan& plan) {
  std::vector<double> bytes;
  ScanOutline outline;
  outline.held = plan.columns();
  for (const auto& beams : plan.beams()) {
    outline.points = beams->size() * plan.pipeline().mostReturns();
    outline.rings = beams->rings;
    outline.columns = beams->columns;
    outline.reach = 2 * beams->maxRange + kReserve;
    for (const FormatChoice& f : plan.pipeline().formats) bytes.push_back(std::ceil(f.format->mostBytes(outline)));
    if (plan.pipeline().layout.reasons) {
      bytes.push_back(static_cast<double>(mostReasonsBytes(beams->rings, beams->columns)));
    }
    if (plan.pipeline().voxels) bytes.push_back(static_cast<double>(mostVoxelsBytes(*plan.pipeline().voxels)));
  }
  return bytes;
}

// What does not grow with the number of samples.
double manifestBytes(const Plan& plan, const Ontology& ontology) {
  const Pipeline& pipeline = plan.pipeline();
  Manifest manifest;
  manifest.name = pipeline.name;
  manifest.pipelineText = pipeline.text;
  manifest.columns = scanColumnNames(plan.columns());
  for (const FormatChoice& f : pipeline.formats) {
    manifest.formats.push_back({std::string(f.entry->name), std::string(f.entry->suffix), f.format->maxError()});
  }
  manifest.ontology = ontology;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    manifest.sensors.push_back({pipeline.sensors[s].name, *plan.beams()[s], pipeline.sensors[s].vehicleFromSensor});
  }
  manifest.modelled = plan.modelled();
  if (pipeline.recording != nullptr) {
    const std::vector<std::string>& lines = pipeline.recording->modelled;
    manifest.modelled.insert(manifest.modelled.end(), lines.begin(), lines.end());
  }
  return bytesOf(toJson(manifest)) + kManifestNotes;
}

}  // namespace

double mostDatasetBytes(const Plan& plan, const Ontology& ontology, std::uint64_t things) {
  const Pipeline& pipeline = plan.pipeline();
  const std::vector<double> scans = scanBytes(plan);
  Manifest alone;
  alone.ontology = ontology;
  const double without = bytesOf(toJson(alone));
  double shards = 0;
  double records = 0;
  for (const Sequence& sequence : pipeline.sequences) {
    const SampleRecord sample = longestSample(plan, sequence, ontology);
    double bytes = static_cast<double>(ShardFile::memberBytes(sample.members[0].size(), sampleJson(sample).size()));
    if (pipeline.objects) {
      const auto length = static_cast<std::uint64_t>(objectsBytes(plan, things));
      bytes += static_cast<double>(ShardFile::memberBytes(sample.key.size() + 1 + kObjectsSuffix.size(), length));
    }
    for (std::size_t i = 0; i < scans.size(); ++i) {
      const auto length = static_cast<std::uint64_t>(scans[i]);
      bytes += static_cast<double>(ShardFile::memberBytes(sample.members[i + 1].size(), length));
    }
    alone.samples = {sample};
    const double record = bytesOf(toJson(alone)) - without + kSeparators;
    shards += bytes * sequence.frames;
    records += record * sequence.frames;
  }
  const auto count = static_cast<double>(shardJobs(plan).size());
  return shards + records + count * (ShardFile::kEndBytes + kShardRecord) + manifestBytes(plan, ontology);
}

double mostSampleBytes(const Plan& plan) {
  constexpr double kHeaders = 1536;       // of a tar member with a long name
  constexpr double kDescription = 16384;  // of a scan, in the sample's .json
  double bytes = kHeaders + kDescription * static_cast<double>(plan.beams().size());
  if (plan.pipeline().objects) bytes += kHeaders + objectsBytes(plan, kUsualObjects);
  for (const double scan : scanBytes(plan)) bytes += scan + kHeaders;
  return bytes;
}

}  // namespace scanmill
