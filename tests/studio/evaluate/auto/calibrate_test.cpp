#include "evaluate/auto/calibrate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/random.h"
#include "evaluate/exact/exact.h"
#include "evaluate/measure.h"
#include "pipeline/run/recorder.h"
#include "pipeline/run/render.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// What nothing exceeds.
constexpr const char* kAnything = "max_error: {max: 1000 m}";
// Two settings of the processor: one exact, one coarse.
constexpr const char* kTwo = "settings: [ray_tracing, {particle: {refine: none, voxel_m: 0.5}}]";
constexpr const char* kTooLarge = "{particle: {field: scene, voxel_m: 0.001}}";

MethodSetting named(const std::string& name) {
  return {{name, "ray_tracing", "{}"}, {&requireMethod("ray_tracing", {}), {}, false}};
}

CalibratedSetting randomRow(std::uint32_t index) {
  const RandomBlock a = randomBlock({.frame = 1, .beam = index});
  const RandomBlock b = randomBlock({.frame = 2, .beam = index});
  CalibratedSetting row{named(fmt::format("setting-{}", index)), {}, {}};
  if (a[0] % 5 == 0) {
    row.failure = "it broke";
    return row;
  }
  GroupErrors& e = row.candidate.errors;
  row.candidate.secondsPerBeam = 1e-9 * (1 + a[1] % 20);  // few values, so that equals occur
  e.beams = 1000;
  e.falseNegatives = a[2] % 30;
  e.bothHit = 900;
  e.bothMiss = 100 - e.falseNegatives;
  e.sameClass = 900 - b[0] % 50;
  e.sameInstance = 900 - b[1] % 50;
  e.sameLabel = std::min(e.sameClass, e.sameInstance);
  e.range.count = 900;
  e.range.median = 1e-3 * (b[2] % 10);
  e.range.p99 = e.range.median + 1e-3 * (b[3] % 50);
  e.range.max = 2 * e.range.p99;
  return row;
}

ErrorLimits randomLimits(std::uint32_t index) {
  const RandomBlock r = randomBlock({.frame = 3, .beam = index});
  ErrorLimits limits;
  if (r[0] % 2 > 0) limits.p99 = 1e-3 * (r[1] % 40);
  if (r[0] % 3 > 0) limits.missRate = 1e-3 * (r[2] % 30);
  if (r[0] % 5 > 1) limits.labels = 1 - 1e-3 * (r[3] % 60);
  if (r[0] % 7 > 3) limits.median = 1e-3 * (r[1] % 9);
  if (r[0] % 11 > 5 || r[0] % 2 == 0) limits.minRate = 1e9 / (1 + r[2] % 25);
  return limits;
}

// Said in other words than the program says it.
bool goodEnough(const Candidate& c, const ErrorLimits& limits) {
  const GroupErrors& e = c.errors;
  if (limits.p99 && e.range.p99 > *limits.p99) return false;
  if (limits.median && e.range.median > *limits.median) return false;
  if (limits.missRate && static_cast<double>(e.falseNegatives) / 1000 > *limits.missRate) return false;
  if (limits.labels && static_cast<double>(e.sameLabel) / 900 < *limits.labels) return false;
  return !limits.minRate || 1 / c.secondsPerBeam >= *limits.minRate;
}

TEST(ChooseSetting, TakesWhatASearchOfTheWholeTableTakes) {
  int chosen = 0;
  int refused = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    std::vector<CalibratedSetting> table;
    for (std::uint32_t s = 0; s < 1 + i % 9; ++s) table.push_back(randomRow(100 * i + s));
    const ErrorLimits limits = randomLimits(i);
    std::optional<std::size_t> best;
    bool any = false;
    for (std::size_t s = 0; s < table.size(); ++s) {
      if (!table[s].failure.empty()) continue;
      any = true;
      if (!goodEnough(table[s].candidate, limits)) continue;
      if (!best || table[s].candidate.secondsPerBeam < table[*best].candidate.secondsPerBeam) best = s;
    }
    if (best) {
      // Within the noise of time the most exact counts; where a rate is all that is asked for, whatever the time.
      const bool rateAlone = !limits.p99 && !limits.median && !limits.missRate && !limits.labels;
      const double cost = table[*best].candidate.secondsPerBeam;
      const auto order = [](const GroupErrors& e) {
        return std::tuple(e.falseNegatives + e.falsePositives + e.unresolved + e.bothHit - e.sameLabel, e.range.p99,
                          e.range.mean);
      };
      for (std::size_t s = 0; s < table.size(); ++s) {
        const Candidate& c = table[s].candidate;
        const bool near = rateAlone || c.secondsPerBeam <= 1.1 * cost;
        if (!table[s].failure.empty() || !goodEnough(c, limits) || !near) continue;
        if (order(c.errors) < order(table[*best].candidate.errors)) best = s;
      }
    }
    const auto choose = [&] { return chooseSetting(table, limits, {"f.yaml", 3, 5}); };
    if (best) {
      EXPECT_EQ(choose(), *best) << i;
      ++chosen;
      continue;
    }
    ++refused;
    const std::string message = messageOf<InputError>(choose);
    EXPECT_THAT(message, HasSubstr("f.yaml:3:5"));
    EXPECT_THAT(message, HasSubstr(any ? "the nearest is setting-" : "it broke"));
  }
  EXPECT_GT(chosen, 300);
  EXPECT_GT(refused, 300);
}

TEST(ChooseSetting, NamesTheNearestAndWhatItLacks) {
  std::vector<CalibratedSetting> table;
  for (const double p99 : {0.5, 0.031, 0.08}) {
    table.push_back({named(fmt::format("p{}", p99)), {}, {}});
    table.back().candidate.secondsPerBeam = 1e-8;
    table.back().candidate.errors.bothHit = table.back().candidate.errors.beams = 10;
    table.back().candidate.errors.range.p99 = p99;
  }
  table.insert(table.begin(), {named("broken"), "no such device", {}});
  ErrorLimits limits;
  limits.p99 = 0.02;
  expectInputError(
      [&] {
        chooseSetting(table, limits, {"f.yaml", 1, 1});
      },
      {"none of the 4 settings keeps the limits", "the nearest is p0.031", "p99 31 mm, but at most 20 mm are allowed",
       "Relax the limits"});
}

class CalibrateYard : public Yard {
 protected:
  Calibration calibrated(const std::string& automatic, std::vector<std::string> overrides = {},
                         const std::atomic<bool>* stop = nullptr) const {
    overrides.insert(overrides.begin(), fmt::format("method={{auto: {{{}}}}}", automatic));
    return calibrate(makePlan(readPipeline(pipeline_, overrides)), true, stop);
  }

  // The pipeline with the method in a block of its own, from line 10 on.
  void expectRefusedMethod(const std::string& block, const std::vector<std::string>& words) const {
    SCOPED_TRACE(block);
    std::string text = kYardPipeline;
    const std::string method = "method: ray_tracing\n";
    const std::size_t at = text.find(method);
    text.erase(at, method.size());
    text.insert(0, "method:\n  auto:\n" + block + "\n");
    const auto file = folder_.write("auto.yaml", text);
    std::vector<std::string> all = words;
    all.emplace_back("auto.yaml:");
    expectInputError([&] { checkAutoChoice(readPipeline(file, {})); }, all);
  }
};

TEST_F(CalibrateYard, EveryWrongTextHasItsPlaceAndAWayOut) {
  expectRefusedMethod("", {"give limits, such as", "min_rate"});
  expectRefusedMethod("    shots: 3", {"auto.yaml:3", "give limits, such as", "max_error"});
  expectRefusedMethod("    max_error: {p99: 2cm}\n    max_errors: {p95: 1cm}",
                      {"auto.yaml:4:5", "unknown key 'max_errors'", "did you mean 'max_error'"});
  expectRefusedMethod("    max_error: {p98: 2cm}", {"auto.yaml:3:17", "unknown key 'p98'"});
  expectRefusedMethod("    max_error: {}", {"auto.yaml:3", "limits are missing"});
  expectRefusedMethod("    min_rate: fast", {"auto.yaml:3:15", "min_rate", "'fast'"});
  expectRefusedMethod("    min_rate: 1\n    shots: 0", {"auto.yaml:4:12", "shots"});
  expectRefusedMethod("    min_rate: 1\n    settings: [rays]", {"auto.yaml:4:16", "unknown method 'rays'"});
  expectRefusedMethod("    max_error: {intensity: 0.1}", {"auto.yaml:3:28", "no effect sets the intensity"});
}

TEST_F(CalibrateYard, OwnSettingsAreNotNeeded) {
  const Pipeline pipeline = readPipeline(pipeline_, {"method={auto: {max_error: {p99: 2cm}}}"});
  const AutoChoice choice = readAutoChoice(pipeline);
  EXPECT_GT(choice.settings.size(), 5u);
  EXPECT_EQ(choice.shots, 3u);
  EXPECT_EQ(choice.limits.p99, 0.02);
  EXPECT_EQ(choice.settings[0].setting.name, "ray_tracing");
}

TEST_F(CalibrateYard, TheExactOneIsLeftWhereNothingMayErr) {
  const Calibration c = calibrated(fmt::format("max_error: {{p99: 1 mm, labels: 100%}}, {}", kTwo));
  ASSERT_EQ(c.settings.size(), 2u);
  EXPECT_EQ(c.chosen, 0u);
  EXPECT_THAT(c.settings[0].failure, IsEmpty());
  EXPECT_THAT(c.settings[1].failure, IsEmpty());
  EXPECT_LT(c.settings[0].candidate.errors.range.max, 1e-5);
  EXPECT_GT(c.settings[1].candidate.errors.range.p99, 0.01);
  EXPECT_THAT(c.why, AllOf(HasSubstr("the cheapest of 1 settings that keep the limits, of 2 measured on 3 frames"),
                           HasSubstr("100.000 % of the labels")));
  const MethodRecord record = c.record();
  EXPECT_EQ(record.setting, "ray_tracing");
  EXPECT_EQ(record.assignment, "method=ray_tracing");
  EXPECT_EQ(record.why, c.why);
}

TEST_F(CalibrateYard, ARateAloneIsEnough) {
  const Calibration c = calibrated(fmt::format("min_rate: 1, {}", kTwo));
  const std::size_t faster = c.settings[1].candidate.secondsPerBeam < c.settings[0].candidate.secondsPerBeam ? 1u : 0u;
  EXPECT_EQ(c.chosen, faster);
  expectInputError([&] { calibrated(fmt::format("min_rate: 1e15, {}", kTwo)); },
                   {"--set method", "none of the 2 settings keeps the limits", "the nearest is ", "min_rate"});
}

TEST_F(CalibrateYard, ABlindSensorIsNoGroundForAChoice) {
  EXPECT_THAT(messageOf<InputError>([&] {
                calibrated("max_error: {p99: 1 m}", {"trajectories=[{name: sky, poses: [{position: [0, 0, 5000]}]}]"});
              }),
              AllOf(HasSubstr("hits anything"), HasSubstr("trajectory")));
}

TEST_F(CalibrateYard, WhatCannotRunHereIsPassedOver) {
  const Calibration c = calibrated(fmt::format("{}, settings: [{}, ray_tracing]", kAnything, kTooLarge));
  EXPECT_THAT(c.settings[0].failure, HasSubstr("voxel_m"));
  EXPECT_EQ(c.chosen, 1u);
  expectInputError([&] { calibrated(fmt::format("{}, settings: [{}]", kAnything, kTooLarge)); },
                   {"none of the 1 settings can run", "voxel_m"});
}

TEST_F(CalibrateYard, IntensitiesAreComparedWhereAnEffectMakesThem) {
  const Calibration c = calibrated(fmt::format("max_error: {{intensity: 1e-6}}, {}", kTwo), {"effects=[intensity]"});
  EXPECT_EQ(c.chosen, 0u);
  EXPECT_GT(c.settings[0].candidate.errors.intensity.count, 0u);
  EXPECT_GT(c.settings[1].candidate.errors.intensity.mean, 1e-6);
}

TEST_F(CalibrateYard, IntensitiesOfSensorsOwnEffectsAreComparedToo) {
  const std::string sensors = "sensors=[" + std::string(kTop).insert(1, "effects: [intensity], ") + "]";
  const Calibration c =
      calibrated(fmt::format("max_error: {{intensity: 1e-6}}, {}", kTwo), {sensors, "effects=sensor"});
  EXPECT_GT(c.settings[0].candidate.errors.intensity.count, 0u);
}

TEST_F(CalibrateYard, AStopEndsIt) {
  const std::atomic<bool> stop = true;
  EXPECT_THAT(messageOf<Error>([&] { calibrated(fmt::format("min_rate: 1, {}", kTwo), {}, &stop); }),
              HasSubstr("stopped"));
}

TEST_F(CalibrateYard, PassesAreNotDrawnOfWhatIsNotChosen) {
  const Plan plan = makePlan(readPipeline(pipeline_, {"method={auto: {min_rate: 1}}"}));
  expectInputError([&] { render(plan, RenderOptions{out(), {}}); }, {"--set method", "auto", "`method: depth_camera`"});
}

// Errors of all beams of two scenes together are at most what calibrate() tells: the worst of the scenes.
TEST_F(CalibrateYard, TheWorstOfTheScenesBoundsAllOfThem) {
  std::string open = yardScene();
  open.replace(open.find("at: [{position: [8, 5, 0.75]}"), 29, "at: [{position: [3, 6, 0.75]}");
  folder_.write("scenes/open.yaml", open);
  const std::string scenes =
      fmt::format("scenes=[{{scene: {0}/yard.yaml}}, {{scene: {0}/open.yaml}}]", (folder_.path() / "scenes").string());
  const Calibration c = calibrated(fmt::format("{}, shots: 8, {}", kAnything, kTwo), {scenes});
  const Plan plan = makePlan(readPipeline(pipeline_, {scenes}));
  ASSERT_EQ(plan.pipeline.sequences.size(), 2u);
  std::vector<double> errors;
  std::uint64_t beams = 0;
  std::uint64_t missed = 0;
  std::uint64_t same = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    ShotSource source(plan);
    const Scene scene = source.load(s);
    const ExactTracer exact(scene);
    const auto method = makeMethod(c.settings[1].setting.choice, scene);
    for (std::uint32_t f = 0; f < 4; ++f) {
      const Shot shot = source.frame(s, f).shots.front();
      ExactHits truth;
      exact.trace(shot, kErrorChannels, truth);
      Hits hits;
      method->trace(shot, kErrorChannels, hits);
      for (std::size_t i = 0; i < hits.size(); ++i) {
        ++beams;
        missed += hits.hit(i) != truth.hits.hit(i) ? 1 : 0;
        if (!hits.hit(i) || !truth.hits.hit(i)) continue;
        errors.push_back(std::abs(double{hits.range[i]} - truth.range[i]));
        same += hits.semantic[i] == truth.hits.semantic[i] && hits.instance[i] == truth.hits.instance[i] ? 1 : 0;
      }
    }
  }
  const GroupErrors& worst = c.settings[1].candidate.errors;
  EXPECT_EQ(worst.beams, beams);
  EXPECT_EQ(worst.bothHit, errors.size());
  EXPECT_EQ(worst.falseNegatives + worst.falsePositives + worst.unresolved, missed);
  EXPECT_EQ(worst.sameLabel, same);
  constexpr double kRounding = 1e-6;  // of errors to float
  const Spread pooled = spreadOf(errors);
  EXPECT_EQ(worst.range.count, pooled.count);
  for (const auto figure : {&Spread::mean, &Spread::rms, &Spread::median, &Spread::p95, &Spread::p99, &Spread::p999}) {
    EXPECT_GE(worst.range.*figure, pooled.*figure * (1 - kRounding));
  }
  EXPECT_NEAR(worst.range.max, pooled.max, kRounding * pooled.max);
}

// A setting that errs too much on one scene is spared the next.
TEST_F(CalibrateYard, WhatIsTooInexactIsMeasuredOnce) {
  folder_.write("scenes/same.yaml", yardScene());
  const std::string scenes =
      fmt::format("scenes=[{{scene: {0}/yard.yaml}}, {{scene: {0}/same.yaml}}]", (folder_.path() / "scenes").string());
  const Calibration c = calibrated(fmt::format("max_error: {{p99: 1 mm}}, min_rate: 1, shots: 2, {}", kTwo), {scenes});
  EXPECT_EQ(c.chosen, 0u);
  EXPECT_EQ(c.settings[0].candidate.errors.beams, 2u * 512);
  EXPECT_EQ(c.settings[1].candidate.errors.beams, 512u);
  EXPECT_GT(c.settings[1].candidate.secondsPerBeam, 0);
  EXPECT_THAT(c.why, HasSubstr("of 2 measured on 2 frames"));
}

// The choice, taken by hand, makes the same dataset.
TEST_F(CalibrateYard, TheChoiceMakesTheDatasetOfItsAssignment) {
  const Plan open = makePlan(
      readPipeline(pipeline_, {fmt::format("method={{auto: {{{}, {}}}}}", kAnything, kTwo), "effects=[intensity]"}));
  const Calibration c = calibrate(open, true);
  const Plan plan = settled(open, c.settings[c.chosen].setting.choice, c.record());
  EXPECT_FALSE(plan.pipeline.method.automatic);
  generate(plan, {.folder = out("auto"), .quiet = true});
  const Manifest manifest = readManifest(out("auto"));
  ASSERT_TRUE(manifest.chosen.has_value());
  EXPECT_EQ(manifest.chosen->setting, c.settings[c.chosen].setting.setting.name);
  EXPECT_EQ(manifest.chosen->why, c.why);
  EXPECT_FALSE(sound({manifest.chosen->assignment, "effects=[intensity]"}, "hand").chosen.has_value());
  EXPECT_EQ(shards("auto"), shards("hand"));
}

// A recording leaves nothing to choose.
TEST_F(CalibrateYard, RecordedHitsNeedNoChoice) {
  generate(makePlan(readPipeline(pipeline_, {}), recordedChannels()),
           {.folder = out("traced"), .keepHits = out("hits"), .quiet = true});
  const Plan plan = makePlan(readPipeline(pipeline_, {"method={auto: {min_rate: 1}}"}, recordingIn(out("hits"))));
  EXPECT_FALSE(plan.pipeline.method.automatic);
  generate(plan, {.folder = out("again"), .quiet = true});
  EXPECT_EQ(shards("again"), shards("traced"));
}

}  // namespace
}  // namespace scanmill
