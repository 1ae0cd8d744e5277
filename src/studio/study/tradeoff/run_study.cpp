#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "base/parallel.h"
#include "base/short_text.h"
#include "base/stage_clock.h"
#include "config/version.h"
#include "gpu/compute.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/scenes/shot_source.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

std::string processorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

// Returns the name of the OpenGL device; empty if the machine has no OpenGL.
std::string graphicsName() {
  try {
    return ComputeDevice({"the device cannot be named", "it is left out"}).name();
  } catch (const Error&) {
    return {};
  }
}

class StudyRun {
 public:
  StudyRun(const Plan& plan, const StudyOptions& options)
      : plan_(plan),
        source_(plan),
        options_(options),
        choice_(readStudyChoice(plan.pipeline)),
        sequence_(plan.pipeline.sequences[choice_.sequence]),
        budget_(options.budgetSeconds > 0 ? options.budgetSeconds : kStudySeconds),
        progress_("tradeoff", choice_.settings.size(), "settings", "beams", options.quiet) {}

  // Each step reads what the steps before it have set.
  Study run() {
    progress_.say("reading the scene");
    scene_ = source_.load(choice_.sequence);
    const bool moves = scene_.moves();
    if (moves) {
      standStill(scene_, 0);
      study_.leftOut.emplace_back("the motion of objects: all stay where they are at the start of the drive");
    }
    describe(moves);
    measureOptions_.repeats = choice_.repeats;
    measureOptions_.leastSeconds = 0.15;
    measureOptions_.channels = plan_.channels;
    measureOptions_.intensity = intensityOfEffects(plan_.pipeline, scene_);
    measureOptions_.stop = [this] { return options_.stop != nullptr && *options_.stop; };
    traceTruth(choice_.shots);
    measureSettings();
    measureEncodings();
    measureSimplifications();
    drawPictures();
    study_.seconds = timer_.seconds();
    return std::move(study_);
  }

 private:
  // Sets the members of the study that do not need a measurement. `moves`: true if objects move in the pipeline.
  void describe(bool moves) {
    const Pipeline& pipeline = plan_.pipeline;
    study_.programVersion = kVersion;
    study_.date = today();
    study_.machine.processor = processorName();
    study_.machine.threads = threadCount();
    const auto usesOpenGl = [](const MethodSetting& s) { return s.choice.entry->can.openGl; };
    if (std::ranges::any_of(choice_.settings, usesOpenGl)) study_.machine.renderer = graphicsName();
    study_.pipelineName = pipeline.name;
    study_.pipelineText = pipeline.text;
    study_.pipelineFile = pipeline.file.string();
    study_.budgetGiven = options_.budgetSeconds > 0;
    study_.budgetSeconds = static_cast<std::uint64_t>(budget_);
    study_.repeats = choice_.repeats;
    study_.scene = {sequence_.key(), scene_.placedTriangles(), {}};
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      const BeamTable& b = *plan_.sensors[s].beams;
      study_.sensors.push_back(
          fmt::format("{}: {}, {} x {} beams", pipeline.sensors[s].name, b.model, b.rings, b.columns));
    }
    study_.ontology = scene_.ontology;
    for (const MethodEntry& entry : methods()) {
      bool isUsable = !moves || entry.can.moving;
      for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
        isUsable = isUsable && (pipeline.lightPaths(s) == nullptr || entry.can.transmission);
      }
      if (!isUsable) study_.refused.emplace_back(entry.name);
    }
  }

  struct ExpectedTime {
    double setUpSeconds = 0, frameSeconds = 0;
  };

  // Returns how long the set-up of a setting and the tracing of the shots take; zeros if the setting cannot run.
  ExpectedTime timeOf(const MethodSetting& setting, const std::vector<Shot>& shots) {
    progress_.say(fmt::format("a first look at {}", setting.setting.method));
    try {
      std::unique_ptr<Method> method;
      Hits hits;
      const auto traceAll = [&] {
        for (const Shot& shot : shots) method->trace(shot, measureOptions_.channels, hits);
      };
      const double setUpSeconds = secondsOf([&] {
        method = makeMethod(setting.choice, scene_);
        method->prepare(shots.front());
        traceAll();
      });
      return {setUpSeconds, secondsOf(traceAll)};
    } catch (const Error&) {
      return {};  // the error is reported when the method's settings are measured
    }
  }

  // Returns the number of scans per shot with which measure() measures a setting: one untimed scan, then timed scans.
  int scansPerShot() const { return choice_.repeats + 1; }

  // Returns the time that the set-ups of all settings and the measurements of one frame probably take. Assumes that all
  // settings of a method take as long as the method's first setting.
  ExpectedTime expectedTime() {
    const std::vector<Shot> shots = source_.frame(choice_.sequence, sequence_.spreadFrames(1).front()).shots;
    std::map<std::string, ExpectedTime> timeOfMethod;
    ExpectedTime sum;
    for (const MethodSetting& s : choice_.settings) {
      if (!timeOfMethod.contains(s.setting.method)) timeOfMethod[s.setting.method] = timeOf(s, shots);
      sum.setUpSeconds += timeOfMethod[s.setting.method].setUpSeconds;
      sum.frameSeconds += timeOfMethod[s.setting.method].frameSeconds * scansPerShot();
    }
    return sum;
  }

  // Selects the frames to measure and traces their exact hits. Takes as many frames as the time budget probably allows,
  // but at most `mostFrames`.
  void traceTruth(std::uint32_t mostFrames) {
    // Fraction of the budget to plan for, since other settings may take longer than the first ones.
    constexpr double kPlannedShare = 0.6;
    // Approximate time per frame for exact hits, edges and distances between clouds (s).
    constexpr double kTruthSeconds = 1.5;
    const ExpectedTime expected = expectedTime();
    const double availableSeconds = kPlannedShare * budget_ - timer_.seconds() - expected.setUpSeconds;
    const double secondsPerFrame = expected.frameSeconds + kTruthSeconds +
                                   measureOptions_.leastSeconds * static_cast<double>(choice_.settings.size());
    const auto count = static_cast<std::uint32_t>(
        std::clamp(availableSeconds / secondsPerFrame, 1.0, static_cast<double>(mostFrames)));
    progress_.say("tracing the truth");
    std::vector<Shot> shots;
    for (const std::uint32_t frame : sequence_.spreadFrames(count)) {
      for (Shot& shot : source_.frame(choice_.sequence, frame).shots) shots.push_back(std::move(shot));
      study_.scene.frames.push_back(frame);
    }
    truth_ = trueShots(scene_, std::move(shots), measureOptions_);
    if (!anyHit(truth_)) {
      throw InputError({plan_.pipeline.file.string()},
                       "no beam of {} scans of {} hits anything, so that nothing can be compared: check "
                       "the trajectory and the sensor's mount, or name another `tradeoff.sequence`",
                       truth_.size(), sequence_.key());
    }
    std::uint64_t beams = 0;
    for (const TrueShot& t : truth_) beams += t.truth.hits.size();
    study_.shots = truth_.size();
    study_.beamsPerShot = beams / truth_.size();
  }

  // Measures the settings, in order, until the budget is used up; adds a line to `leftOut` for each other setting.
  void measureSettings() {
    for (const MethodSetting& s : choice_.settings) {
      checkStopped();
      // At least one setting is measured, whatever the budget.
      if (!study_.settings.empty() && timer_.seconds() > budget_) {
        study_.leftOut.push_back(fmt::format("{}: the budget of {} was used up", s.setting.name, shortTime(budget_)));
        progress_.advance(1, 0);
        continue;
      }
      progress_.say(s.setting.name);
      SettingResult result{s.setting, {}, {}};
      try {
        result.measured = measure([&] { return makeMethod(s.choice, scene_); }, scene_, truth_, measureOptions_);
      } catch (const Error& error) {
        checkStopped();  // an error because the user has stopped the study is no failure of the setting
        result.failure = error.what();
      }
      study_.settings.push_back(std::move(result));
      progress_.advance(1, static_cast<double>(study_.beamsPerShot * study_.shots) * scansPerShot());
    }
  }

  // Measures, on one thread, the stages after tracing: effects, the pipeline's formats, and the encodings of the study.
  void measureEncodings() {
    constexpr std::size_t kEncodedScans = 4;
    const ThreadLimit oneThread(1);
    progress_.say("encodings");
    const auto tracer = makeReference(scene_);
    std::vector<Scan> scans;
    double effectsSeconds = 0;
    Hits hits;
    Returns returns;
    Scan scan;
    for (const TrueShot& t : truth_) {
      if (scans.size() == kEncodedScans) break;
      tracer->trace(t.shot, plan_.channels, hits);
      const ShotSetup setup = setupOf(plan_, source_.settings(), scene_, *tracer, t.shot.sensor);
      // The first call is not timed: it allocates the buffers that later calls reuse.
      senseShot(setup, t.shot, hits, returns, scan);
      effectsSeconds += secondsOf([&] { senseShot(setup, t.shot, hits, returns, scan); });
      scans.push_back(scan);
    }
    const auto count = static_cast<double>(scans.size());
    study_.commonStages["effects"] = effectsSeconds / count;
    for (const ChosenFormat& format : plan_.pipeline.output.formats) {
      const WallTimer timer;
      for (const Scan& s : scans) format.format->encode(s);
      study_.commonStages[fmt::format("encode {}", format.entry->name)] = timer.seconds() / count;
    }
    for (const StudyEncoding& encoding : choice_.encodings) {
      checkStopped();
      study_.encodings.push_back(measureEncoding(encoding, scans, choice_.repeats));
    }
  }

  // Measures simplified physics on one frame only: with 127 rays per beam, the reference takes as long as 127 scans.
  void measureSimplifications() {
    std::vector<Shot> shots;
    for (const TrueShot& t : truth_) {
      if (t.shot.frame == truth_.front().shot.frame) shots.push_back(t.shot);
    }
    study_.sensing = measureSensing(
        plan_, scene_, shots, [this](const std::string& name) { progress_.say(name); }, measureOptions_.stop);
  }

  // For each method with noticeable errors, draws pictures of the first setting that has such errors and of the setting
  // with the largest 99th percentile of the range error.
  void drawPictures() {
    constexpr double kNoticeableError = 1e-3, kNoticeableMissRate = 1e-4;  // m; fraction of the beams
    if (!options_.drawErrors) return;
    std::map<std::string, std::vector<const SettingResult*>> erringOfMethod;
    for (const SettingResult& s : study_.settings) {
      const GroupErrors& errors = s.measured.errors.all;
      const bool isErring = errors.range.p999 > kNoticeableError || errors.missRate() > kNoticeableMissRate;
      if (s.failure.empty() && isErring) erringOfMethod[s.setting.method].push_back(&s);
    }
    std::set<std::string> picturedSettings;
    for (const auto& [method, results] : erringOfMethod) {
      picturedSettings.insert(results.front()->setting.name);
      const auto p99 = [](const SettingResult* s) { return s->measured.errors.all.range.p99; };
      picturedSettings.insert((*std::ranges::max_element(results, {}, p99))->setting.name);
    }
    for (const MethodSetting& s : choice_.settings) {
      if (!picturedSettings.contains(s.setting.name)) continue;
      checkStopped();
      progress_.say(fmt::format("picture of {}", s.setting.name));
      try {
        Hits hits;
        makeMethod(s.choice, scene_)->trace(truth_.front().shot, kErrorChannels, hits);
        study_.pictures.push_back({s.setting.name, options_.drawErrors(truth_.front(), hits)});
      } catch (const Error& error) {
        study_.leftOut.push_back(fmt::format("picture of {}: {}", s.setting.name, error.what()));
      }
    }
  }

  void checkStopped() const {
    if (options_.stop != nullptr && *options_.stop) throw Error("interrupted: nothing was written");
  }

  const Plan& plan_;
  ShotSource source_;
  StudyOptions options_;
  StudyChoice choice_;
  const Sequence& sequence_;
  double budget_;
  Progress progress_;
  WallTimer timer_;
  Scene scene_;
  MeasureOptions measureOptions_;
  std::vector<TrueShot> truth_;
  Study study_;
};

}  // namespace

Study runStudy(const Plan& plan, const StudyOptions& options) {
  if (plan.pipeline.recording != nullptr) {
    throw InputError({plan.pipeline.file.string()},
                     "a study traces the scene itself, so that it cannot use a recording");
  }
  return StudyRun(plan, options).run();
}

}  // namespace scanmill
