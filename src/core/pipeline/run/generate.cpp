#include "pipeline/run/generate.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/writer.h"
#include "formats/reasons_png.h"
#include "methods/depth_camera/depth_camera.h"
#include "pipeline/plan/scene_shares.h"
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

class DatasetRun {
 public:
  DatasetRun(const Plan& plan, const GenerateOptions& options)
      : plan_(plan),
        pipeline_(plan.pipeline()),
        options_(options),
        recorder_(plan),
        progress_("generate", plan.pipeline().frames(), "frames", "rays", options.quiet) {
    summary_.manifest = startManifest(plan);
  }

  // The story: every frame of every sequence becomes a sample, samples are written in order, the manifest comes last.
  GenerateSummary run() {
    for (std::size_t s = 0; s < pipeline_.sequences.size(); ++s) {
      enter(s);
      framesInOrder<MadeSample>(
          pipeline_.sequences[s].frames, plan_.framesInFlight(), options_.stop,
          [&](std::uint32_t frame) { return makeSample(s, frame); }, [&](const MadeSample& made) { write(made); });
      leave(pipeline_.sequences[s]);
    }
    return finish();
  }

 private:
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

  // Scene and method of a sequence, new ones where the one before had another scene; then, once, the output.
  void enter(std::size_t s) {
    const Sequence& sequence = pipeline_.sequences[s];
    if (s == 0 || !sequence.sameScene(pipeline_.sequences[s - 1])) {
      const StageTimer timer(clock_, "setup");
      progress_.say(fmt::format("setting up {}", sequence.key()));
      addSeconds(account_.seconds, methodSeconds_);
      account_ = {};
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
    if (!writer_) {
      // Only now: a scene or a method that cannot be used must not cost the dataset that --overwrite replaces.
      recorder_.open(options_.keepHits, options_.keepPasses, options_.overwrite);
      writer_.emplace(options_.folder, options_.overwrite, pipeline_.shardBytes);
      summary_.manifest.ontology = scene_->ontology;
    }
    recorder_.enter(s, *scene_, *method_);
    addNew(method_->modelled(), summary_.manifest.modelled);
    pointsOfSensor_.clear();
  }

  void write(const MadeSample& made) {
    account_ += made.account;
    {
      const StageTimer timer(clock_, "write");
      writer_->add(made.sample);
    }
    for (const ScanRecord& record : made.sample.scans) {
      summary_.beams += record.beams;
      summary_.points += record.points;
      pointsOfSensor_[record.sensor] += record.points;
      for (const auto& [id, count] : record.pointsPerClass) summary_.pointsPerClass[id] += count;
    }
    progress_.advance(1, static_cast<double>(pipeline_.raysPerFrame()));
  }

  void leave(const Sequence& sequence) {
    addNew(account_.warningTexts(), summary_.warnings);
    for (const auto& [sensor, points] : pointsOfSensor_) {
      if (points > 0) continue;
      summary_.warnings.push_back(
          fmt::format("sequence {}: the sensor '{}' sees nothing in {} frames: is the trajectory "
                      "inside the scene?",
                      sequence.key(), sensor, sequence.frames));
    }
    if (options_.stop != nullptr && *options_.stop) {
      throw Error("stopped: the folder holds no manifest, hence no finished dataset");
    }
  }

  GenerateSummary finish() {
    addSeconds(account_.seconds, methodSeconds_);
    StageSeconds& stages = summary_.manifest.stages;
    stages = clock_.seconds();
    if (!methodSeconds_.empty()) stages.erase("trace");  // its parts are known
    for (const StageSeconds& own : {methodSeconds_, recorder_.stageSeconds()}) {
      for (const auto& [stage, seconds] : own) stages[stage] = seconds;
    }
    recorder_.finish();
    writer_->finish(summary_.manifest);
    summary_.bytes = writer_->bytesWritten();
    summary_.seconds = progress_.seconds();
    return std::move(summary_);
  }

  const Plan& plan_;
  const Pipeline& pipeline_;
  const GenerateOptions& options_;
  GenerateSummary summary_;
  StageClock clock_;
  BufferPool<ShotBuffers> buffers_;
  std::optional<DatasetWriter> writer_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Method> method_;
  std::optional<SceneProbe> probe_;
  TraceAccount account_;        // of the method
  StageSeconds methodSeconds_;  // of the methods before it
  Recorder recorder_;
  Progress progress_;
  std::map<std::string, std::uint64_t> pointsOfSensor_;  // of the sequence
};

}  // namespace

GenerateSummary generate(const Plan& plan, const GenerateOptions& options) {
  checkFolders(plan, options);
  if (!options.keepPasses.empty()) plan.requirePasses();
  if (!options.keepHits.empty() || !options.keepPasses.empty()) plan.requireOneRay();
  return DatasetRun(plan, options).run();
}

}  // namespace scanmill
