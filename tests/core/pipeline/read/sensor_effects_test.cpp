// Pipelines whose effects come from their sensors' files.

#include "pipeline/plan/recorded_method.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

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
    for (const EffectEntry* e : p.effectEntriesOf(sensor)) result.emplace_back(e->name);
    return result;
  }

 private:
  static std::string sensor(const std::string& effects) {
    return "columns: 32\nrate_hz: 10\nelevation_deg: {top: 5, bottom: -20, rings: 8}\nrange_m: [0.5, 100]\n" + effects;
  }
  TemporaryFolder folder_;
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

TEST_F(SensorEffectsOf, AreLeftOutOtherwise) {
  const std::string noise = "effects: [range_noise: {sigma_m: 0.1}]\n";
  const Pipeline none = pipeline("", noise, noise);
  EXPECT_TRUE(names(none, 0).empty());
  EXPECT_THAT(names(pipeline("effects: [intensity]\n", noise, ""), 1), ElementsAre("intensity"));
  EXPECT_THAT(Plan(pipeline("", noise, "")).modelled(), Contains(HasSubstr("effects of the file of 'a': left out")));
}

TEST_F(SensorEffectsOf, EachScanHasItsOwn) {
  const TemporaryFolder out;
  const Plan plan(
      pipeline("effects: sensor\n", "effects: [quantize: {step_m: 0.5}]\n", "effects: [dropout: {probability: 1}]\n"));
  EXPECT_THAT(plan.modelled(),
              AllOf(Contains(HasSubstr("effect quantize of 'a'")), Contains(HasSubstr("effect dropout of 'b'"))));
  GenerateOptions options;
  options.folder = out.path() / "out";
  options.quiet = true;
  const GenerateSummary summary = generate(plan, options);
  const std::vector<ScanRecord>& scans = summary.manifest.samples.front().scans;
  EXPECT_GT(scans[0].points, 100u);
  EXPECT_EQ(scans[1].points, 0u);
}

TEST_F(SensorEffectsOf, ChannelsAreThoseOfAllSensors) {
  const Plan plan(
      pipeline("effects: sensor\n", "effects: [intensity, quantize: {step_m: 0.5}]\n", "effects: [intensity]\n"));
  EXPECT_TRUE(plan.channels().has(Channel::Incidence));
  const Plan second(pipeline("effects: sensor\n", "effects: []\n", "effects: [angular_jitter: {sigma_deg: 0.1}]\n"));
  EXPECT_TRUE(second.channels().has(Channel::Range));
}

TEST_F(SensorEffectsOf, DoNotChangeTheBeams) {
  const Plan plain(pipeline("", "", ""));
  const Plan noisy(pipeline("effects: sensor\n", "effects: [quantize: {step_m: 0.5}]\n", "effects: []\n"));
  EXPECT_EQ(beamsHash(*plain.beams()[0]), beamsHash(*noisy.beams()[0]));
}

TEST_F(SensorEffectsOf, AreRefusedWithAdvice) {
  const std::string noise = "effects: [range_noise: {sigma_m: 0.1}]\n";
  EXPECT_THAT(refusal("effects: sensor\n", noise, ""),
              AllOf(HasSubstr("yard.yaml:"), HasSubstr("'b'"), HasSubstr("fit-noise"), HasSubstr("name effects here")));
  EXPECT_THAT(refusal("effects: [range_noise: {sigma_m: 1}, sensor]\n", noise, noise),
              HasSubstr("'range_noise' stands twice"));
  EXPECT_THAT(refusal("effects: sensor\n", "effects: [intensity]\n", noise),
              AllOf(HasSubstr("only one has an intensity"), HasSubstr("'b'")));
  EXPECT_THAT(refusal("effects: sensors\n", noise, noise), HasSubstr("`sensor`"));
  EXPECT_THAT(refusal("", "effects: {range_noise: {sigma_m: 1}}\n", ""),
              AllOf(HasSubstr("first.yaml:"), HasSubstr("must be a list")));
  EXPECT_THAT(refusal("", "effects: [range_nois]\n", ""),
              AllOf(HasSubstr("first.yaml:"), HasSubstr("did you mean 'range_noise'")));
  EXPECT_THAT(refusal("", "effects: [sensor]\n", ""), HasSubstr("unknown effect 'sensor'"));
}

}  // namespace
}  // namespace scanmill
