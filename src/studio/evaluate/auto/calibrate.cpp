#include "evaluate/auto/calibrate.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/short_text.h"
#include "evaluate/measure.h"
#include "pipeline/run/forecast.h"
#include "pipeline/run/progress.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostScenes = 3;

Value defaultSettings() {
  std::string list;
  for (const MethodEntry& method : methods()) list += method.autoSettings;
  return parseYaml(list, "settings of auto");
}

// Returns upper bounds of the percentiles and means for the union of two sets of errors: the larger value of the two
// sets.
Spread worstOf(const Spread& a, const Spread& b) {
  Spread s;
  s.count = a.count + b.count;
  for (double Spread::*value :
       {&Spread::mean, &Spread::rms, &Spread::median, &Spread::p95, &Spread::p99, &Spread::p999, &Spread::max}) {
    s.*value = std::max(a.*value, b.*value);
  }
  return s;
}

GroupErrors worstOf(const GroupErrors& a, const GroupErrors& b) {
  GroupErrors e;
  for (std::uint64_t GroupErrors::*count :
       {&GroupErrors::beams, &GroupErrors::bothHit, &GroupErrors::bothMiss, &GroupErrors::falseNegatives,
        &GroupErrors::falsePositives, &GroupErrors::unresolved, &GroupErrors::sameClass, &GroupErrors::sameInstance,
        &GroupErrors::sameLabel}) {
    e.*count = a.*count + b.*count;
  }
  e.range = worstOf(a.range, b.range);
  e.intensity = worstOf(a.intensity, b.intensity);
  return e;
}

// Returns the indices of sequences with different scenes, spread over all sequences of the pipeline: at most `most` and
// at most kMostScenes.
std::vector<std::size_t> sequencesOf(const Pipeline& pipeline, std::size_t most) {
  std::vector<std::size_t> firsts;
  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    if (s == 0 || !pipeline.sequences[s].sameScene(pipeline.sequences[s - 1])) firsts.push_back(s);
  }
  const std::size_t count = std::min({most, firsts.size(), kMostScenes});
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(firsts[i * firsts.size() / count]);
  return chosen;
}

class Calibrator {
 public:
  Calibrator(const Plan& plan, bool quiet, const std::atomic<bool>* stop)
      : plan_(plan),
        source_(plan),
        pipeline_(plan.pipeline),
        choice_(readAutoChoice(pipeline_)),
        stop_(stop),
        scenes_(sequencesOf(pipeline_, choice_.shots)),
        progress_("calibrate", scenes_.size() * choice_.settings.size(), "settings", "beams", quiet) {
    errorLimits_.minRate.reset();
  }

  Calibration run() {
    Calibration calibration;
    for (const MethodSetting& s : choice_.settings) calibration.settings.push_back({s, {}, {}});
    sums_.resize(choice_.settings.size());
    for (std::size_t i = 0; i < scenes_.size(); ++i) measureScene(i, calibration);
    const double beams = pipeline_.rays();
    for (std::size_t s = 0; s < sums_.size(); ++s) {
      const double parts = std::max(sums_[s].scenes, 1);
      const double setup = sums_[s].setup / parts * static_cast<double>(scenesOf(pipeline_));
      calibration.settings[s].candidate.secondsPerBeam = setup / beams + sums_[s].perBeam / parts;
    }
    calibration.chosen = chooseSetting(calibration.settings, choice_.limits, pipeline_.method.options.where);
    calibration.why = reason(calibration);
    return calibration;
  }

 private:
  struct Sum {
    double setup = 0;    // set-up time (s), summed over scenes
    double perBeam = 0;  // time per beam (s), summed over scenes
    int scenes = 0;      // number of scenes on which the setting was measured
  };

  // Excludes methods that ignore motion; called if objects of the scene move. The other methods are measured with all
  // objects at their positions at time 0 s.
  static void refuseStill(Calibration& calibration) {
    for (CalibratedSetting& row : calibration.settings) {
      const MethodEntry& entry = *row.setting.choice.entry;
      if (!entry.can.moving && row.failure.empty())
        row.failure = "the method cannot trace the moving objects of the scene: see the key `moving`";
    }
  }

  void measureScene(std::size_t index, Calibration& calibration) {
    const std::size_t sequence = scenes_[index];
    const Sequence& own = pipeline_.sequences[sequence];
    progress_.say(fmt::format("reading {}", own.key()));
    Scene scene = source_.load(sequence);
    if (scene.moves()) refuseStill(calibration);
    standStill(scene, 0);
    // The shots are divided evenly among the scenes; the first scenes get the remainder.
    const auto shares = static_cast<std::uint32_t>(scenes_.size());
    const std::uint32_t count = choice_.shots / shares + (index < choice_.shots % shares ? 1 : 0);
    std::vector<Shot> shots;
    for (const std::uint32_t frame : own.spreadFrames(count)) {
      ++frames_;
      for (Shot& shot : source_.frame(sequence, frame).shots) shots.push_back(std::move(shot));
    }
    const MeasureOptions options{.leastSeconds = 0.1,
                                 .clouds = false,
                                 .channels = plan_.channels,
                                 .intensity = noiseFreeIntensity(pipeline_, scene),
                                 .stop = [this] { return stop_ != nullptr && *stop_; }};
    const std::vector<TrueShot> truth = trueShots(scene, std::move(shots), options);
    if (!anyHit(truth)) {
      throw InputError({pipeline_.file.string()},
                       fmt::format("no beam of {} scans of {} hits anything, so that no setting can be judged: check "
                                   "the trajectory and the sensor's mount",
                                   truth.size(), own.key()));
    }
    double beams = 0;
    for (const TrueShot& t : truth) beams += static_cast<double>(t.truth.hits.size());
    beams /= static_cast<double>(truth.size());
    for (std::size_t s = 0; s < calibration.settings.size(); ++s) {
      CalibratedSetting& row = calibration.settings[s];
      progress_.say(row.setting.setting.name);
      // A setting that exceeds an error limit on the scenes before need not be measured on further ones.
      if (row.failure.empty() && (index == 0 || broken(row.candidate, errorLimits_).empty())) {
        try {
          const Measurement m = measure([&] { return makeMethod(row.setting.choice, scene); }, scene, truth, options);
          sums_[s].setup += m.cost.setupSeconds;
          sums_[s].perBeam += m.cost.scanSeconds / beams;
          ++sums_[s].scenes;
          row.candidate.errors = index == 0 ? m.errors.all : worstOf(row.candidate.errors, m.errors.all);
        } catch (const Error& error) {
          if (options.stop()) throw;
          row.failure = error.what();
        }
      }
      progress_.advance(1, beams * static_cast<double>(truth.size()) * (options.repeats + 1));
    }
  }

  std::string reason(const Calibration& calibration) const {
    const CalibratedSetting& chosen = calibration.settings[calibration.chosen];
    const GroupErrors& e = chosen.candidate.errors;
    std::size_t holding = 0;
    for (const CalibratedSetting& s : calibration.settings) {
      holding += s.failure.empty() && broken(s.candidate, choice_.limits).empty() ? 1 : 0;
    }
    const bool onlyRate = limitTexts(chosen.candidate, errorLimits_).empty();
    return fmt::format(
        "the {} of {} settings that keep the limits, of {} measured on {} frames; limits: {}; it traces {} beams/s "
        "with set-up, range error p99 {:.3g} mm, {:.3f} % of the beams are false negatives or positives, {:.3f} % of "
        "the labels agree",
        onlyRate ? "most exact" : "cheapest", holding, calibration.settings.size(), frames_,
        fmt::join(limitTexts(chosen.candidate, choice_.limits), "; "), shortNumber(1 / chosen.candidate.secondsPerBeam),
        e.range.p99 * 1e3, 100 * e.missRate(), 100 * e.labels());
  }

  const Plan& plan_;
  ShotSource source_;
  const Pipeline& pipeline_;
  AutoChoice choice_;
  ErrorLimits errorLimits_ = choice_.limits;  // the limits without the rate
  const std::atomic<bool>* stop_;
  std::vector<std::size_t> scenes_;
  Progress progress_;
  std::vector<Sum> sums_;
  std::uint32_t frames_ = 0;  // number of frames measured so far
};

}  // namespace

AutoChoice readAutoChoice(const Pipeline& pipeline) {
  const Value& options = pipeline.method.options;
  AutoChoice choice;
  Fields fields(options, "method auto");
  fields.also({"max_error", "min_rate", "settings", "shots"}).finish();
  if (!fields.has("max_error") && !fields.has("min_rate")) {
    throw InputError(options.where,
                     "method auto: give limits, such as {auto: {max_error: {p99: 2cm, miss_rate: 0.1%, labels: "
                     "99.5%}}} or {auto: {min_rate: 5e6}}");
  }
  choice.limits = readErrorLimits(fields.find("max_error"), fields.find("min_rate"));
  const Value* settings = fields.find("settings");
  choice.settings = readSettings(settings == nullptr ? defaultSettings() : *settings, "method auto: settings");
  choice.shots = static_cast<std::uint32_t>(fields.integer("shots", 1, 1000, 3));
  if (choice.limits.intensity && !setsIntensity(pipeline)) {
    throw InputError(fields.find("max_error")->find("intensity")->where,
                     "method auto: max_error: no effect sets the intensity: add the effect `intensity`, or "
                     "leave this limit out");
  }
  return choice;
}

void checkAutoChoice(const Pipeline& pipeline) {
  if (pipeline.method.automatic) readAutoChoice(pipeline);
}

std::size_t chooseSetting(const std::vector<CalibratedSetting>& settings, const ErrorLimits& limits,
                          const Location& where) {
  std::vector<Candidate> candidates;
  std::vector<std::size_t> index;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    if (!settings[s].failure.empty()) continue;
    candidates.push_back(settings[s].candidate);
    index.push_back(s);
  }
  if (candidates.empty()) {
    throw InputError(where, fmt::format("method auto: none of the {} settings can run; the first failed: {}",
                                        settings.size(), settings.empty() ? "" : settings.front().failure));
  }
  if (const auto best = bestThatHolds(candidates, limits)) return index[*best];
  const std::size_t nearestOne = nearestToHolding(candidates, limits);
  throw InputError(where, fmt::format("method auto: none of the {} settings keeps the limits; the nearest is {} ({}). "
                                      "Relax the limits, or name more `settings`",
                                      settings.size(), settings[index[nearestOne]].setting.setting.name,
                                      fmt::join(broken(candidates[nearestOne], limits), "; ")));
}

MethodRecord Calibration::record() const {
  const Setting& s = settings[chosen].setting.setting;
  return {s.name, s.assignment(), why};
}

Calibration calibrate(const Plan& plan, bool quiet, const std::atomic<bool>* stop) {
  return Calibrator(plan, quiet, stop).run();
}

}  // namespace scanmill
