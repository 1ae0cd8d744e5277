// Pipelines whose effects come from their sensors' files.

#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/lines_of.h"

namespace scanmill {
namespace {

using testing::IsSupersetOf;

class SensorEffectsOf : public testing::Test {
 protected:
  Pipeline pipeline(const std::string& effects, const std::string& first, const std::string& second) const {
    folder_.write("scenes/yard.yaml", yardScene());
    folder_.write("first.yaml", sensor(first));
    folder_.write("second.yaml", sensor(second));
    return readPipeline(folder_.write("yard.yaml",
                                      "scenes: [{scene: scenes/yard.yaml}]\n"
                                      "trajectories: [{poses: [{position: [0, 0, 2]}]}]\n"
                                      "sensors: [{name: a, preset: first.yaml}, {name: b, preset: second.yaml}]\n"
                                      "method: ray_tracing\n"
                                      "output: {layout: organised, columns: [range_true], formats: [pcd]}\n" +
                                          effects),
                        {});
  }
  std::string refusal(const std::string& effects, const std::string& first, const std::string& second) const {
    return messageOf([&] { pipeline(effects, first, second); });
  }
  static std::vector<std::string> names(const Pipeline& p, std::size_t sensor) {
    std::vector<std::string> result;
    for (const ChosenEffect& e : *p.sensors[sensor].effects) result.emplace_back(e.entry->name);
    return result;
  }

  TemporaryFolder folder_;

 private:
  static std::string sensor(const std::string& effects) {
    return "columns: 32\nrate_hz: 10\nelevation_deg: {top: 5, bottom: -20, rings: 8}\nrange_m: [0.5, 100]\n" + effects;
  }
};

TEST_F(SensorEffectsOf, AreTakenWhereThePipelineSaysSo) {
  const std::string noise = "effects: [quantize: {step_m: 0.5}, range_noise: {sigma_m: 0.1}]\n";
  const std::string loss = "effects: [dropout: {probability: 1}]\n";
  for (const char* asked : {"effects: sensor\n", "effects: [sensor]\n"}) {
    const Pipeline p = pipeline(asked, noise, loss);
    EXPECT_THAT(names(p, 0), ElementsAre("range_noise", "quantize")) << "by stage";
    EXPECT_THAT(names(p, 1), ElementsAre("dropout"));
  }
  const Pipeline both = pipeline("effects: [intensity, sensor]\n", noise, loss);
  EXPECT_THAT(names(both, 0), ElementsAre("intensity", "range_noise", "quantize"));
  EXPECT_THAT(names(both, 1), ElementsAre("intensity", "dropout"));
}

// A later item changes the keys that it names of the sensor's own, and `none` leaves that out.
TEST_F(SensorEffectsOf, CanBeChangedOneByOne) {
  const std::string own = "effects: [range_noise: {sigma_m: 0.1, sigma_per_m: 0.01}, quantize: {step_m: 0.5}]\n";
  const auto scanned = [&](const std::string& effects, const std::string& list) {
    const TemporaryFolder out;
    generate(makePlan(pipeline(effects, list, list)), {.folder = out.path() / "out", .quiet = true});
    return readFile(out.path() / "out/train/train-000000.tar");
  };
  const auto same = [&](const std::string& effects, const std::string& list) {
    EXPECT_EQ(scanned(effects, own), scanned("effects: sensor\n", list)) << effects;
  };
  same("effects: [sensor, range_noise: {sigma_per_m: 0.02}]\n",
       "effects: [range_noise: {sigma_m: 0.1, sigma_per_m: 0.02}, quantize: {step_m: 0.5}]\n");
  same("effects: [range_noise: {sigma_per_m: null}, sensor]\n",
       "effects: [range_noise: {sigma_m: 0.1}, quantize: {step_m: 0.5}]\n");
  same("effects: [sensor, range_noise: none]\n", "effects: [quantize: {step_m: 0.5}]\n");
  same("effects: [sensor, range_noise, intensity: none]\n", own);
  EXPECT_NE(scanned("effects: sensor\n", own), scanned("effects: [sensor, quantize: {step_m: 0.4}]\n", own));
  EXPECT_THAT(names(pipeline("effects: [sensor, range_noise: none]\n", own, own), 1), ElementsAre("quantize"));
}

// The key `label` is a class of the scenes' ontology, by its id or its name.
TEST_F(SensorEffectsOf, NameTheirClass) {
  const std::string wide = "divergence_mrad: 3\npulse_ns: 5\neffects: [intensity]\n";
  const auto weather = [](const std::string& label) {
    return "effects: [sensor, weather: {kind: fog, label: " + label + "}]\n";
  };
  for (const char* good : {"noise", "61", "0", "outlier"}) EXPECT_NO_THROW(pipeline(weather(good), wide, wide)) << good;
  EXPECT_THAT(refusal(weather("nois"), wide, wide), AllOf(HasSubstr("yard.yaml:"), HasSubstr("'noise'")));
  EXPECT_THAT(refusal(weather("99"), wide, wide),
              AllOf(HasSubstr("yard.yaml:"), HasSubstr("label"), HasSubstr("has the id 99")));
  EXPECT_THAT(refusal(weather("-1"), wide, wide), HasSubstr("yard.yaml:"));
  EXPECT_THAT(refusal("effects: sensor\n", wide, "effects: [blooming: {label: 99}, intensity]\n"),
              HasSubstr("second.yaml:"));
}

TEST_F(SensorEffectsOf, AreLeftOutOtherwise) {
  const std::string noise = "effects: [range_noise: {sigma_m: 0.1}]\n";
  const Pipeline none = pipeline("", noise, noise);
  EXPECT_TRUE(names(none, 0).empty());
  EXPECT_THAT(names(pipeline("effects: [intensity]\n", noise, ""), 1), ElementsAre("intensity"));
  EXPECT_THAT(linesOf(modelled(makePlan(pipeline("", noise, "")), {})),
              Contains(HasSubstr("effects of the sensor's file of 'a': left out (`effects: sensor`")));
}

// Effects that the pipeline itself gives to one of its sensors are warned of if it does not apply them.
TEST_F(SensorEffectsOf, ThoseOfThePipelineAreNotLeftOutInSilence) {
  const auto warnings = [&](const std::string& effects) {
    pipeline("", "", "");
    return sensorWarnings(makePlan(
        readPipeline(folder_.write("own.yaml",
                                   "scenes: [{scene: scenes/yard.yaml}]\n"
                                   "trajectories: [{poses: [{position: [0, 0, 2]}]}]\n"
                                   "sensors: [{name: a, preset: first.yaml, effects: [dropout: {probability: 1}]}]\n"
                                   "method: ray_tracing\noutput: {formats: [pcd]}\n" +
                                       effects),
                     {})));
  };
  EXPECT_THAT(warnings("effects: [intensity]\n"), ElementsAre(AllOf(HasSubstr("own.yaml:"), HasSubstr("not applied"))));
  EXPECT_THAT(warnings("effects: sensor\n"), IsEmpty());
}

TEST_F(SensorEffectsOf, EachScanHasItsOwn) {
  const TemporaryFolder out;
  const Plan plan = makePlan(
      pipeline("effects: sensor\n", "effects: [quantize: {step_m: 0.5}]\n", "effects: [dropout: {probability: 1}]\n"));
  EXPECT_THAT(linesOf(modelled(plan, {})),
              AllOf(Contains(HasSubstr("effect quantize of 'a'")), Contains(HasSubstr("effect dropout of 'b'"))));
  const GenerateSummary summary = generate(plan, {.folder = out.path() / "out", .quiet = true});
  const std::vector<ScanRecord>& scans = summary.manifest.samples.front().scans;
  EXPECT_GT(scans[0].points, 100u);
  EXPECT_EQ(scans[1].points, 0u);
}

// Rain and fog need the width of the beam, the pulse and the near range; usual values stand for those that a sensor's
// file lacks.
TEST_F(SensorEffectsOf, ValuesThatWeatherAssumesAreReported) {
  const std::string lit = "effects: [intensity]\n";
  for (const char* weather : {"{kind: rain}", "{kind: fog, visibility_m: {uniform: [50, 90], per: frame}}"}) {
    const Plan plan = makePlan(pipeline(fmt::format("effects: [sensor, weather: {}]\n", weather), lit,
                                        "divergence_mrad: 2\neffects: [intensity: {near_range_m: 8}]\n"));
    EXPECT_THAT(sensorWarnings(plan),
                ElementsAre(AllOf(HasSubstr("'a'"), HasSubstr("`divergence_mrad: 3` and `pulse_ns: 5`")),
                            AllOf(HasSubstr("'a'"), HasSubstr("the default `near_range_m: 1`")),
                            AllOf(HasSubstr("'b'"), HasSubstr("does not give `pulse_ns: 5`"))));
  }
}

TEST_F(SensorEffectsOf, ChannelsAreThoseOfAllSensors) {
  const Plan plan = makePlan(
      pipeline("effects: sensor\n", "effects: [intensity, quantize: {step_m: 0.5}]\n", "effects: [intensity]\n"));
  EXPECT_TRUE(plan.channels.has(Channel::Incidence));
  const Plan second =
      makePlan(pipeline("effects: sensor\n", "effects: []\n", "effects: [angular_jitter: {sigma_deg: 0.1}]\n"));
  EXPECT_TRUE(second.channels.has(Channel::Range));
}

TEST_F(SensorEffectsOf, AreRefusedWithAdvice) {
  const std::string noise = "effects: [range_noise: {sigma_m: 0.1}]\n";
  expectRefusals([&](const std::string& effects) { return refusal(effects + "\n", noise, noise); },
                 {{"effects: [range_noise: {sigma_m: 1}, sensor, range_noise: {sigma_m: 2}]",
                   "yard.yaml: | 'range_noise' is listed twice"},
                  {"effects: [sensor, sensor]", "`sensor` is listed twice"},
                  {"effects: [sensor, range_nois: none]", "did you mean 'range_noise'"},
                  {"effects: [sensor, range_noise: 3]", "the keys to change"},
                  {"effects: [sensor, range_noise: {sigma: 3}]", "yard.yaml: | did you mean 'sigma_m'"},
                  {"effects: sensors", "`sensor`"}});
  expectRefusals([&](const std::string& own) { return refusal("effects: sensor\n", own + "\n", noise); },
                 {{"effects: {range_noise: {sigma_m: 1}}", "first.yaml: | must be a list"},
                  {"effects: [range_nois]", "first.yaml: | did you mean 'range_noise'"},
                  {"effects: [sensor]", "unknown effect 'sensor'"}});
  expectRefusals([&](const std::string& own) { return refusal("effects: sensor\n", own, own.empty() ? "" : noise); },
                 {{"", "yard.yaml: | 'a' | fit-noise | effects: [intensity] | name effects here"},
                  {"effects: [intensity]\n", "has an intensity, but all scans | 'b'"}});
  EXPECT_THAT(refusal("effects: [intensity]\n", noise, "effects: [range_nois]\n"), HasSubstr("second.yaml:"))
      << "unused";
  EXPECT_TRUE(names(pipeline("effects: [range_noise: none, none]\n", noise, noise), 0).empty());
}

TEST_F(SensorEffectsOf, OfEveryPresetArePlanned) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines/sensors")) {
    if (readYaml(entry.path()).find("effects") == nullptr) continue;
    folder_.write("scenes/yard.yaml", yardScene());
    const Plan plan =
        makePlan(readPipeline(folder_.write("yard.yaml",
                                            "scenes: [{scene: scenes/yard.yaml}]\n"
                                            "trajectories: [{poses: [{position: [0, 0, 2]}]}]\n"
                                            "sensors: [{preset: " +
                                                entry.path().string() +
                                                "}]\n"
                                                "method: ray_tracing\neffects: sensor\noutput: {formats: [pcd]}\n"),
                              {}));
    EXPECT_THAT(names(plan.pipeline, 0), IsSupersetOf({"intensity", "speckle", "detection", "range_noise"}))
        << entry.path();
    ++count;
  }
  EXPECT_GT(count, 10);
}

}  // namespace
}  // namespace scanmill
