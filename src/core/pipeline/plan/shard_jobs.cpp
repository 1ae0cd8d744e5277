#include "pipeline/plan/shard_jobs.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/random.h"
#include "config/resources.h"
#include "config/version.h"
#include "dataset/names.h"
#include "dataset/recording.h"
#include "dataset/shard_writer.h"
#include "dataset/voxels.h"
#include "formats/reasons_png.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Adds a YAML value's contents to a hash, without its file and line number.
void addValue(const Value& value, const std::function<void(std::string_view)>& add) {
  add(fmt::format("{}", static_cast<int>(value.kind)));
  add(value.text);
  for (const Value& item : value.items) addValue(item, add);
  for (const Value::Entry& entry : value.entries) {
    add(entry.key);
    addValue(entry.value, add);
  }
}

// Adds the names and sizes of a recording's files to a hash. The files' contents are not hashed, since reading all
// images would take too long.
void addRecording(const fs::path& folder, const std::function<void(std::string_view)>& add) {
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files.insert(fmt::format("{} {}", entry.path().filename().string(), entry.file_size()));
    }
  }
  for (const std::string& file : files) add(file);
}

// Returns the hash that datasetPlan() describes.
std::string planHash(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline;
  Sha256 hash;
  const auto add = [&](std::string_view text) { hash.add(fmt::format("{}:{}\n", text.size(), text)); };
  add(kVersion);
  add(fmt::format("{}", Manifest::kSchemaVersion));
  add(pipeline.text);
  for (const auto& [beams, footprint] : plan.sensors) add(beamsHash(*beams));
  for (const MountedSensor& sensor : pipeline.sensors) addValue(sensor.description, add);
  std::set<fs::path> files;
  for (const Sequence& sequence : pipeline.sequences) files.insert(sequence.sceneFile);
  files.insert({pipeline.vehicle, pipeline.ontology});
  for (const fs::path& file : files) {
    if (isFile(file)) add(readFile(file));  // recordings have no scene files
  }
  if (pipeline.recording != nullptr) addRecording(pipeline.recording->folder, add);
  return hash.hex();
}

// Sorts samples by random numbers. The random number of a sample depends only on the seed, the sample's sequence and
// its frame, not on other samples.
void shuffle(std::uint64_t seed, std::vector<SampleAddress>& samples) {
  const auto rank = [&](const SampleAddress& sample) {
    const RandomBlock random = randomBlock({.seed = seed,
                                            .scene = static_cast<std::uint32_t>(sample.sequence),
                                            .frame = sample.frame,
                                            .purpose = Purpose::Shuffle});
    return std::tuple(random[0], random[1], sample.number);
  };
  std::ranges::sort(samples, {}, rank);
}

}  // namespace

double mostSampleBytes(const Plan& plan) {
  constexpr double kHeaderBytes = 1536;  // bytes of a tar member's headers and padding, if its name is long
  constexpr double kScanBytes = 16384;   // bytes of a scan's entry in the sample's .json
  constexpr double kMostObjects = 1000;  // assumed number of objects near the sensors
  constexpr double kObjectBytes = 700;   // bytes of an object's entry, without the sensors' views
  constexpr double kViewBytes = 450;     // bytes of one sensor's view in an object's entry
  constexpr double kReserve = 10;  // m, added to twice the range, for noise and the vehicle's motion in a revolution
  const Pipeline& pipeline = plan.pipeline;
  const auto sensorCount = static_cast<double>(plan.sensors.size());
  double bytes = kHeaderBytes;
  if (pipeline.output.objects) bytes += kHeaderBytes + kMostObjects * (kObjectBytes + kViewBytes * sensorCount);
  ScanOutline outline;
  outline.held = plan.columns();
  for (std::size_t s = 0; s < plan.sensors.size(); ++s) {
    const std::shared_ptr<const BeamTable>& beams = plan.sensors[s].beams;
    double scanBytes = kScanBytes;
    outline.points = beams->size() * pipeline.mostReturns();
    outline.rings = beams->rings;
    outline.columns = beams->columns;
    outline.reach = 2 * beams->maxRange + kReserve;
    for (const ChosenFormat& f : pipeline.output.formats)
      scanBytes += kHeaderBytes + std::ceil(f.format->mostBytes(outline));
    if (pipeline.output.layout.reasons) {
      scanBytes += kHeaderBytes + static_cast<double>(mostReasonsBytes(beams->rings, beams->columns));
    }
    if (pipeline.output.voxels)
      scanBytes += kHeaderBytes + static_cast<double>(mostVoxelsBytes(*pipeline.output.voxels));
    bytes += scanBytes * pipeline.sensors[s].revolutions;
  }
  return bytes;
}

std::vector<ShardJob> shardJobs(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline;
  std::vector<std::pair<std::string, std::vector<SampleAddress>>> splits;  // name and samples of each split
  std::uint64_t number = 0;
  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    const Sequence& sequence = pipeline.sequences[s];
    auto split = std::ranges::find_if(splits, [&](const auto& other) { return other.first == sequence.split; });
    if (split == splits.end()) split = splits.emplace(splits.end(), sequence.split, std::vector<SampleAddress>{});
    for (std::uint32_t frame = 0; frame < sequence.frames; ++frame) split->second.push_back({s, frame, number++});
  }
  const double shardBytes = static_cast<double>(pipeline.output.shards.bytes) - ShardFile::kEndBytes;
  const auto fitting = static_cast<std::size_t>(std::max(1.0, std::floor(shardBytes / mostSampleBytes(plan))));
  const std::size_t stated = pipeline.output.shards.samples;  // samples per shard; 0: as many as fit
  std::vector<ShardJob> jobs;
  for (auto& [name, samples] : splits) {
    if (pipeline.output.shards.shuffled) shuffle(pipeline.seed, samples);
    const std::size_t total = samples.size();
    const auto shardsOf = [&](std::size_t samplesPerShard) { return (total + samplesPerShard - 1) / samplesPerShard; };
    const std::size_t shards =
        stated > 0 ? shardsOf(stated) : std::max(shardsOf(fitting), std::min<std::size_t>(2, total));
    for (std::size_t i = 0; i < shards; ++i) {
      const std::size_t first = stated > 0 ? i * stated : total * i / shards;
      const std::size_t end = stated > 0 ? std::min(total, first + stated) : total * (i + 1) / shards;
      ShardJob job{.file = shardName(name, i),
                   .split = name,
                   .samples = {samples.begin() + static_cast<std::ptrdiff_t>(first),
                               samples.begin() + static_cast<std::ptrdiff_t>(end)}};
      std::ranges::sort(job.samples, {}, &SampleAddress::number);
      jobs.push_back(std::move(job));
    }
  }
  return jobs;
}

std::vector<DatasetPlan::Split> splitsOf(const std::vector<ShardJob>& jobs) {
  std::vector<DatasetPlan::Split> splits;
  for (const ShardJob& job : jobs) {
    if (splits.empty() || splits.back().name != job.split) splits.push_back({job.split});
    ++splits.back().shards;
  }
  return splits;
}

DatasetPlan datasetPlan(const Plan& plan, const std::vector<ShardJob>& jobs) {
  DatasetPlan planned{.hash = planHash(plan), .samples = 0, .splits = splitsOf(jobs)};
  for (const ShardJob& job : jobs) planned.samples += job.samples.size();
  return planned;
}

}  // namespace scanmill
