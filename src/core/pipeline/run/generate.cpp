#include "pipeline/run/generate.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/dataset_folder.h"
#include "dataset/shard_writer.h"
#include "formats/reasons_png.h"
#include "methods/depth_camera/depth_camera.h"
#include "pipeline/plan/scene_shares.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/plan/warnings.h"
#include "pipeline/plan/way_warnings.h"
#include "pipeline/run/buffer_pool.h"
#include "pipeline/run/frames_in_order.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/recorder.h"
#include "pipeline/run/run_folders.h"
#include "pipeline/run/run_records.h"
#include "pipeline/run/run_shot.h"

namespace scanmill {

namespace {

struct MadeSample {
  Sample sample;
  TraceAccount account;  // of tracing all its shots
};

void addNew(const std::vector<std::string>& from, std::vector<std::string>& lines) {
  for (const std::string& line : from) {
    if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
  }
}

FolderUse useOf(const GenerateOptions& options) {
  return options.resume ? FolderUse::Resume : options.overwrite ? FolderUse::Replace : FolderUse::New;
}

// What is known of a shard that is whole.
struct Part {
  ShardRecord shard;
  std::vector<SampleRecord> samples;
  std::vector<std::string> modelled;
};

class DatasetRun {
 public:
  DatasetRun(const Plan& plan, const GenerateOptions& options)
      : plan_(plan),
        pipeline_(plan.pipeline()),
        options_(options),
        jobs_(shardJobs(plan)),
        folder_(options.folder, useOf(options), planHash(plan)),
        recorder_(plan),
        progress_("generate", plan.pipeline().frames(), "frames", "rays", options.quiet) {
    summary_.manifest = startManifest(plan);
  }

  // The story: every shard is made by itself, and the manifest comes last.
  GenerateSummary run() {
    for (const ShardJob& job : jobs_) {
      std::optional<Manifest> part = folder_.kept(job.file);
      if (part) {
        resume(*part);
      } else {
        part = make(job);
        folder_.keep(*part);
      }
      summary_.manifest.ontology = std::move(part->ontology);
      parts_.push_back({std::move(part->shards.front()), std::move(part->samples), std::move(part->modelled)});
    }
    return finish();
  }

 private:
  Manifest make(const ShardJob& job) {
    ShardWriter shard(folder_.staging(), job.file, job.split);
    Manifest part = startManifest(plan_);
    for (auto first = job.samples.begin(); first != job.samples.end();) {
      const auto last = std::find_if(first, job.samples.end(),
                                     [&](const SampleAddress& other) { return other.sequence != first->sequence; });
      enter(first->sequence);
      addNew(method_->modelled(), part.modelled);
      framesInOrder<MadeSample>(
          static_cast<std::uint32_t>(last - first), plan_.framesInFlight(), options_.stop,
          [&](std::uint32_t i) { return makeSample(first->sequence, first[i].frame); },
          [&](const MadeSample& made) { write(made, shard); });
      if (options_.stop != nullptr && *options_.stop) {
        throw Error("stopped: the folder holds no manifest, hence no finished dataset; --resume goes on with it");
      }
      first = last;
    }
    const StageTimer timer(clock_, "write");
    ShardPart made = shard.finish();
    part.ontology = scene_->ontology;
    part.shards = {std::move(made.shard)};
    part.samples = std::move(made.samples);
    return part;
  }

  void resume(const Manifest& part) {
    ++summary_.resumedShards;
    progress_.advance(part.samples.size(), static_cast<double>(part.samples.size() * pipeline_.raysPerFrame()));
  }

  // All sensors of a frame: traced, sensed and encoded. Threads run each stage's work by themselves, but for tracing,
  // which may be helped by idle ones; so what the clock adds up is close to, not exactly, the time on processors.
  MadeSample makeSample(std::size_t sequence, std::uint32_t frame) {
    MadeSample made;
    made.sample.key = pipeline_.sequences[sequence].key(frame);
    made.sample.split = pipeline_.sequences[sequence].split;
    std::unique_ptr<ShotBuffers> buffers = buffers_.take();
    for (const Shot& shot : plan_.shots(sequence, frame)) {
      const ShotSetup setup = setupOf(plan_, *scene_, *method_, shot.sensor);
      if (recorder_.recordsPasses()) {
        made.account += drawAndRecord(shot, buffers->hits);
        const StageTimer timer(clock_, "effects");
        senseShot(setup, shot, buffers->hits, buffers->returns, buffers->scan);
      } else {
        made.account += runShot(setup, shot, *buffers, clock_);
      }
      if (recorder_.recordsHits()) recorder_.writeHits(shot, buffers->hits);
      made.sample.scans.push_back(recordOf(shot, buffers->hits, buffers->scan, pipeline_.methodName()));
      const StageTimer timer(clock_, "encode");
      for (const FormatChoice& f : pipeline_.formats) {
        made.sample.members.push_back(
            {memberSuffix(made.sample.scans.back(), f.format->suffix()), f.format->encode(buffers->scan)});
      }
      if (pipeline_.layout.reasons) {
        made.sample.members.push_back(
            {memberSuffix(made.sample.scans.back(), kReasonsSuffix),
             encodeReasons(buffers->scan.reasonOfBeam, buffers->scan.rings, buffers->scan.columns)});
      }
    }
    buffers_.give(std::move(buffers));
    return made;
  }

  // Passes that are recorded are drawn first, and the hits are sampled from them.
  TraceAccount drawAndRecord(const Shot& shot, Hits& hits) {
    const DepthCamera& camera = *method_->depthCamera();
    hits.reset(shot.beams->rings, shot.beams->columns, plan_.channels());
    PassChoice choice = camera.passes(plan_.channels());
    choice.surfaceParameters = plan_.channels().has(Channel::Material);
    RecordedShot record = Recorder::beginPasses(shot);
    TraceAccount sampling;
    TraceAccount account = camera.draw(shot, choice, [&](PassStep&& step) {
      recorder_.writeStep(step, record);
      sampling += camera.sample(shot, step, hits);
    });
    recorder_.writePasses(record);
    return account += sampling;
  }

  // Scene and method of a sequence, new ones where the one before had another scene.
  void enter(std::size_t s) {
    const Sequence& sequence = pipeline_.sequences[s];
    if (!entered_ || !sequence.sameScene(pipeline_.sequences[*entered_])) {
      const StageTimer timer(clock_, "setup");
      progress_.say(fmt::format("setting up {}", sequence.key()));
      closeAccount();
      probe_.reset();
      method_.reset();
      scene_.reset();
      scene_ = std::make_unique<Scene>(plan_.loadScene(sequence));
      method_ = plan_.makeMethod(*scene_);
      for (const Shot& shot : plan_.shots(s, 0)) account_ += method_->prepare(shot);
      addNew(sizeWarnings(*scene_), summary_.warnings);
      addNew(thingSizeWarnings(*scene_), summary_.warnings);
      addNew(ruleWarnings(*scene_), summary_.warnings);
      addNew(unlabeledWarnings(*scene_), summary_.warnings);
      addNew(seedWarnings(pipeline_, sequence, *scene_), summary_.warnings);
      addNew(shareWarnings(*scene_), summary_.warnings);
      addNew(vehicleWarnings(plan_), summary_.warnings);
      addNew(driveWarnings(pipeline_), summary_.warnings);
      if (pipeline_.recording == nullptr) probe_.emplace(*scene_, method_.get(), pipeline_.method.entry);
    }
    if (probe_) addNew(wayWarnings(plan_, s, *probe_), summary_.warnings);
    // Only now: a scene or a method that cannot be used must not cost the recordings that --overwrite replaces.
    if (!entered_) recorder_.open(options_.keepHits, options_.keepPasses, options_.overwrite);
    entered_ = s;
    recorder_.enter(s, *scene_, *method_);
  }

  // Of a method that is done: what it warns of counts all its beams, whatever shards they are in.
  void closeAccount() {
    addSeconds(account_.seconds, methodSeconds_);
    addNew(account_.warningTexts(), summary_.warnings);
    account_ = {};
  }

  void write(const MadeSample& made, ShardWriter& shard) {
    account_ += made.account;
    {
      const StageTimer timer(clock_, "write");
      shard.add(made.sample);
    }
    progress_.advance(1, static_cast<double>(pipeline_.raysPerFrame()));
  }

  // Of all parts, whoever made them: shards in the order of the plan, samples in that of the sequences.
  void join() {
    Manifest& manifest = summary_.manifest;
    std::vector<std::size_t> firstOf{0};  // of each sequence, among all samples
    for (const Sequence& sequence : pipeline_.sequences) firstOf.push_back(firstOf.back() + sequence.frames);
    manifest.samples.resize(firstOf.back());
    for (std::size_t j = 0; j < jobs_.size(); ++j) {
      addNew(parts_[j].modelled, manifest.modelled);
      manifest.shards.push_back(std::move(parts_[j].shard));
      for (std::size_t i = 0; i < jobs_[j].samples.size(); ++i) {
        const auto [sequence, frame] = jobs_[j].samples[i];
        SampleRecord& sample = manifest.samples[firstOf[sequence] + frame];
        sample = std::move(parts_[j].samples[i]);
        sample.shard = static_cast<std::uint32_t>(j);
      }
    }
    for (std::size_t s = 0; s < pipeline_.sequences.size(); ++s) {
      std::map<std::string, std::uint64_t> pointsOfSensor;
      for (std::size_t i = firstOf[s]; i < firstOf[s + 1]; ++i) count(manifest.samples[i], pointsOfSensor);
      for (const auto& [sensor, points] : pointsOfSensor) {
        if (points > 0) continue;
        summary_.warnings.push_back(
            fmt::format("sequence {}: the sensor '{}' sees nothing in {} frames: is the trajectory "
                        "inside the scene?",
                        pipeline_.sequences[s].key(), sensor, pipeline_.sequences[s].frames));
      }
    }
  }

  void count(const SampleRecord& sample, std::map<std::string, std::uint64_t>& pointsOfSensor) {
    for (const ScanRecord& record : sample.scans) {
      summary_.beams += record.beams;
      summary_.points += record.points;
      pointsOfSensor[record.sensor] += record.points;
      for (const auto& [id, points] : record.pointsPerClass) summary_.pointsPerClass[id] += points;
    }
  }

  GenerateSummary finish() {
    closeAccount();
    StageSeconds& stages = summary_.stages;
    stages = clock_.seconds();
    if (!methodSeconds_.empty()) stages.erase("trace");  // its parts are known
    for (const StageSeconds& own : {methodSeconds_, recorder_.stageSeconds()}) {
      for (const auto& [stage, seconds] : own) stages[stage] = seconds;
    }
    recorder_.finish();
    join();
    folder_.publish(summary_.manifest);
    for (const ShardRecord& shard : summary_.manifest.shards) summary_.bytes += shard.bytes;
    summary_.seconds = progress_.seconds();
    return std::move(summary_);
  }

  const Plan& plan_;
  const Pipeline& pipeline_;
  const GenerateOptions& options_;
  std::vector<ShardJob> jobs_;
  DatasetFolder folder_;
  std::vector<Part> parts_;             // of the jobs so far
  std::optional<std::size_t> entered_;  // the sequence whose scene is there
  GenerateSummary summary_;
  StageClock clock_;
  BufferPool<ShotBuffers> buffers_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Method> method_;
  std::optional<SceneProbe> probe_;
  TraceAccount account_;        // of the method
  StageSeconds methodSeconds_;  // of the methods before it
  Recorder recorder_;
  Progress progress_;
};

}  // namespace

GenerateSummary generate(const Plan& plan, const GenerateOptions& options) {
  checkFolders(plan, options);
  if (!options.keepPasses.empty()) plan.requirePasses();
  if (!options.keepHits.empty() || !options.keepPasses.empty()) {
    plan.requireOneRay();
    if (options.resume) throw InputError("--resume goes on with datasets, not with recordings: begin anew");
  }
  return DatasetRun(plan, options).run();
}

}  // namespace scanmill
