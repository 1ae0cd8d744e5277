#include "pipeline/generate.h"

#include <fmt/core.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/handover.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "base/stage_clock.h"
#include "config/version.h"
#include "dataset/writer.h"
#include "pipeline/keeper.h"
#include "pipeline/progress.h"
#include "pipeline/warnings.h"

namespace scanmill {

namespace {

// Buffers that go from frame to frame, so that memory stays flat.
struct Workspace {
  Hits hits;
  Returns returns;
  Scan scan;
};

class WorkspacePool {
 public:
  std::unique_ptr<Workspace> take() {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return std::make_unique<Workspace>();
    auto workspace = std::move(idle_.back());
    idle_.pop_back();
    return workspace;
  }
  void give(std::unique_ptr<Workspace> workspace) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(workspace));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> idle_;
};

// Beams of which a ray was given up. A beam's rays need not follow one another.
std::uint64_t unresolvedBeams(const Hits& hits) {
  if (hits.beamOfRay.empty()) return hits.unresolved.size();
  std::vector<std::uint32_t> beams;
  for (const std::uint32_t ray : hits.unresolved) beams.push_back(hits.beamOfRay[ray]);
  std::sort(beams.begin(), beams.end());
  return static_cast<std::uint64_t>(std::unique(beams.begin(), beams.end()) - beams.begin());
}

ScanRecord describe(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method) {
  ScanRecord record;
  record.sensor = shot.sensorName;
  record.method = method;
  record.time = shot.time;
  record.worldFromSensor.push_back(shot.worldFromSensor.front());
  if (shot.worldFromSensor.size() > 1) record.worldFromSensor.push_back(shot.worldFromSensor.back());
  record.beams = hits.size();
  record.unresolved = unresolvedBeams(hits);
  std::vector<std::uint64_t> perClass;
  std::vector<std::uint32_t> instances;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    ++record.points;
    if (!scan[kLabel].empty()) {
      if (scan[kLabel][i] >= perClass.size()) perClass.resize(scan[kLabel][i] + std::size_t{1});
      ++perClass[scan[kLabel][i]];
    }
    if (!scan[kInstance].empty() && scan[kInstance][i] != 0 &&
        (instances.empty() || instances.back() != scan[kInstance][i])) {
      instances.push_back(scan[kInstance][i]);
    }
  }
  for (std::size_t c = 0; c < perClass.size(); ++c) {
    if (perClass[c] > 0) record.pointsPerClass[static_cast<std::uint16_t>(c)] = perClass[c];
  }
  std::sort(instances.begin(), instances.end());
  record.instances = static_cast<std::uint32_t>(std::unique(instances.begin(), instances.end()) - instances.begin());
  return record;
}

struct MadeSample {
  Sample sample;
  TraceAccount account;  // of tracing all its shots
};

// One frame: all sensors, traced, sensed and encoded. Threads run each stage's work by themselves, but for tracing,
// which may be helped by idle ones; so what `clock` adds up is close to, not exactly, the time on processors.
MadeSample makeSample(const Plan& plan, const Scene& scene, const Method& method, Keeper& keeper, std::size_t sequence,
                      std::uint32_t frame, Workspace& work, StageClock& clock) {
  const Pipeline& pipeline = plan.pipeline();
  MadeSample made;
  Sample& sample = made.sample;
  sample.key = pipeline.sequences[sequence].key(frame);
  sample.split = pipeline.sequences[sequence].split;
  for (const Shot& shot : plan.shots(sequence, frame)) {
    if (!keeper.keepsPasses()) {
      const StageTimer timer(clock, "trace");
      made.account += method.trace(shot, plan.channels(), work.hits);
    }
    if (keeper.keeps()) made.account += keeper.keep(shot, plan.channels(), work.hits);
    {
      const StageTimer timer(clock, "effects");
      sense(work.hits, shot, pipeline.effectsOf(shot.sensor), scene.materials, pipeline.layout, work.returns,
            work.scan);
      sample.scans.push_back(describe(shot, work.hits, work.scan, pipeline.methodName()));
    }
    const StageTimer encoding(clock, "encode");
    for (const FormatChoice& f : pipeline.formats) {
      sample.members.push_back({memberSuffix(sample.scans.back(), f.format->suffix()), f.format->encode(work.scan)});
    }
  }
  return made;
}

Manifest startManifest(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline();
  Manifest manifest;
  manifest.programVersion = kVersion;
  manifest.name = pipeline.name;
  manifest.pipelineText = pipeline.text;
  manifest.pipelineSha256 = sha256(pipeline.text);
  manifest.seed = pipeline.seed;
  manifest.organised = pipeline.layout.organised;
  manifest.deskewed = pipeline.motion.deskew;
  manifest.columns = scanColumnNames(plan.columns());
  for (const FormatChoice& f : pipeline.formats) {
    manifest.formats.push_back({std::string(f.entry->name), std::string(f.entry->suffix), f.format->maxError()});
  }
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    manifest.sensors.push_back({pipeline.sensors[s].name, *plan.beams()[s], pipeline.sensors[s].vehicleFromSensor});
    BeamTable& beams = manifest.sensors.back().beams;  // the manifest holds the table per ring
    beams.direction = {};
    beams.origin = {};
    beams.time = {};
  }
  manifest.modelled = plan.modelled();
  manifest.chosen = plan.chosen();
  return manifest;
}

void addNew(const std::vector<std::string>& from, std::vector<std::string>& lines) {
  for (const std::string& line : from) {
    if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
  }
}

// Dataset and recordings each have a folder of their own, none within another: --overwrite must know what is whose.
void checkFolders(const Plan& plan, const GenerateOptions& options) {
  std::vector<std::filesystem::path> folders;
  const auto add = [&](const std::filesystem::path& folder) {
    if (folder.empty()) return;
    std::error_code ignored;
    std::filesystem::path own = std::filesystem::weakly_canonical(std::filesystem::absolute(folder), ignored);
    if (!own.has_filename()) own = own.parent_path();
    for (const std::filesystem::path& other : folders) {
      const auto relative = [](const auto& a, const auto& b) { return a.lexically_relative(b).string(); };
      if (own == other || !relative(own, other).starts_with("..") || !relative(other, own).starts_with("..")) {
        throw InputError({folder.string()}, "dataset and recordings need folders of their own, none within another");
      }
    }
    folders.push_back(std::move(own));
  };
  add(options.folder);
  add(options.keepHits);
  add(options.keepPasses);
  if (plan.pipeline().recording != nullptr) add(plan.pipeline().recording->folder);
}

// source gives numbers one after the other until it stops, make works on several at a time, write gets them in order.
template <class Source, class Make, class Write>
void inOrder(std::size_t inFlight, const Source& source, const Make& make, const Write& write) {
  using Number = std::uint32_t;
  Handover begun;
  Handover made;
  const Handover::Wait forFirst(begun, begun);
  const Handover::Wait forThird(begun, made);
  const auto first = [&](tbb::flow_control& control) SCANMILL_UNWATCHED -> Number {
    const Handover::Turn turn(begun, begun);
    return source(control);
  };
  const auto second = [&](Number number) SCANMILL_UNWATCHED -> Number {
    const Handover::Turn turn(begun, made);
    make(number);
    return number;
  };
  const auto third = [&](Number number) SCANMILL_UNWATCHED {
    const Handover::Turn turn(made, made);
    write(number);
  };
  tbb::parallel_pipeline(inFlight, tbb::make_filter<void, Number>(tbb::filter_mode::serial_in_order, first) &
                                       tbb::make_filter<Number, Number>(tbb::filter_mode::parallel, second) &
                                       tbb::make_filter<Number, void>(tbb::filter_mode::serial_in_order, third));
}

}  // namespace

GenerateSummary generate(const Plan& plan, const GenerateOptions& options) {
  checkFolders(plan, options);
  if (!options.keepPasses.empty()) plan.requirePasses();
  if (!options.keepHits.empty()) plan.requireOneRay();
  const Pipeline& pipeline = plan.pipeline();
  GenerateSummary summary;
  summary.manifest = startManifest(plan);
  StageClock clock;
  WorkspacePool pool;
  std::optional<DatasetWriter> writer;
  std::unique_ptr<Scene> scene;
  std::unique_ptr<Method> method;
  TraceAccount account;        // of the method
  StageSeconds methodSeconds;  // of the methods before it
  Keeper keeper(plan);
  Progress progress("generate", pipeline.frames(), "frames", "rays", options.quiet);
  const auto raysPerFrame = static_cast<double>(pipeline.raysPerFrame());
  const std::size_t inFlight = plan.framesInFlight();

  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    const Sequence& sequence = pipeline.sequences[s];
    if (s == 0 || !sequence.sameScene(pipeline.sequences[s - 1])) {
      const StageTimer timer(clock, "setup");
      progress.say(fmt::format("setting up {}", sequence.key()));
      addSeconds(account.seconds, methodSeconds);
      account = {};
      keeper.leave();
      method.reset();
      scene.reset();
      scene = std::make_unique<Scene>(plan.loadScene(sequence));
      method = plan.makeMethod(*scene);
      for (const Shot& shot : plan.shots(s, 0)) account += method->prepare(shot);
      addNew(sizeWarnings(*scene), summary.warnings);
      addNew(seedWarnings(pipeline, sequence, *scene), summary.warnings);
    }
    if (!writer) {
      // Only now: a scene or a method that cannot be used must not cost the dataset that --overwrite replaces.
      keeper.open(options.keepHits, options.keepPasses, options.overwrite);
      writer.emplace(options.folder, options.overwrite, pipeline.shardBytes);
      summary.manifest.ontology = scene->ontology;
    }
    keeper.enter(s, *scene, *method);
    addNew(method->modelled(), summary.manifest.modelled);

    std::map<std::string, std::uint64_t> pointsOfSensor;
    std::uint32_t next = 0;
    // Both ends run in order: among the frames in flight, no two have the same slot.
    std::vector<std::unique_ptr<const MadeSample>> slots(inFlight);
    const auto source = [&](tbb::flow_control& control) -> std::uint32_t {
      if (next == sequence.frames || (options.stop != nullptr && *options.stop)) {
        control.stop();
        return 0;
      }
      return next++;
    };
    const auto make = [&](std::uint32_t frame) {
      auto work = pool.take();
      slots[frame % inFlight] =
          std::make_unique<const MadeSample>(makeSample(plan, *scene, *method, keeper, s, frame, *work, clock));
      pool.give(std::move(work));
    };
    const auto write = [&](std::uint32_t frame) {
      const std::unique_ptr<const MadeSample> made = std::move(slots[frame % inFlight]);
      account += made->account;
      {
        const StageTimer timer(clock, "write");
        writer->add(made->sample);
      }
      for (const ScanRecord& record : made->sample.scans) {
        summary.rays += record.beams;
        summary.points += record.points;
        pointsOfSensor[record.sensor] += record.points;
        for (const auto& [id, count] : record.pointsPerClass) summary.pointsPerClass[id] += count;
      }
      progress.advance(1, raysPerFrame);
    };
    inOrder(inFlight, source, make, write);
    addNew(account.warningTexts(), summary.warnings);
    for (const auto& [sensor, points] : pointsOfSensor) {
      if (points > 0) continue;
      summary.warnings.push_back(
          fmt::format("sequence {}: the sensor '{}' sees nothing in {} frames: is the trajectory "
                      "inside the scene?",
                      sequence.key(), sensor, sequence.frames));
    }
    if (options.stop != nullptr && *options.stop) {
      throw Error("stopped: the folder holds no manifest, hence no finished dataset");
    }
  }
  addSeconds(account.seconds, methodSeconds);
  summary.manifest.stages = clock.seconds();
  if (!methodSeconds.empty()) {
    summary.manifest.stages.erase("trace");  // its parts are known
    for (const auto& [stage, seconds] : methodSeconds) summary.manifest.stages[stage] = seconds;
  }
  for (const auto& [stage, seconds] : keeper.stageSeconds()) summary.manifest.stages[stage] = seconds;
  keeper.finish();
  writer->finish(summary.manifest);
  summary.bytes = writer->bytesWritten();
  summary.seconds = progress.seconds();
  return summary;
}

}  // namespace scanmill
