#include "pipeline/read/effects.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

std::string corrupted(const std::string& effects, const std::string& corruption) {
  return flowText(withCorruption(parseYaml(effects, "x.yaml"), parseYaml(corruption, "y.yaml")));
}

TEST(Corruption, AddsEffectsOrChangesTheirKeys) {
  EXPECT_EQ(corrupted("", "{lost_rings: light}"), "[{dropout: {rings: 0.25}}]");
  EXPECT_EQ(corrupted("sensor", "{fog: heavy}"), "[sensor, {weather: {kind: fog, severity: heavy}}]");
  EXPECT_EQ(corrupted("[{dropout: {threshold: 0.1, rings: 0.9}}, speckle]", "{lost_rings: heavy}"),
            "[{dropout: {threshold: 0.1, rings: 0.75}}, speckle]");
  EXPECT_EQ(corrupted("[sensor, {dropout: none}]", "{lost_rings: light}"), "[sensor, {dropout: {rings: 0.25}}]");
  EXPECT_EQ(corrupted("[{weather: {kind: rain, rate_mm_h: 5, wet: 0.6}}]", "{fog: light}"),
            "[{weather: {kind: fog, severity: light}}]");
  EXPECT_EQ(corrupted("[{dropout: {choice: [none, {rings: 0.5}]}}]", "{lost_rings: light}"),
            "[{dropout: {rings: 0.25}}]");
  EXPECT_THAT(messageOf([] { corrupted("{choice: [[intensity], []]}", "{fog: light}"); }),
              HasSubstr("complete list is random"));
  EXPECT_EQ(corrupted("[{choice: [none, intensity]}]", "{lost_rings: light}"),
            "[{choice: [none, intensity]}, {dropout: {rings: 0.25}}]");
}

TEST(Corruption, EveryOneHasThreeSeveritiesThatARealSensorTakes) {
  const std::vector<std::string> names = corruptionNames();
  EXPECT_THAT(names, testing::IsSupersetOf(
                         {"crosstalk", "fog", "incomplete_echo", "lost_rings", "snow", "vibration", "wet_ground"}));
  const std::filesystem::path quickstart = std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines/quickstart.yaml";
  const Pipeline clean = readPipeline(quickstart, {});
  for (const std::string& name : names) {
    EXPECT_FALSE(corruptionSummary(name).empty()) << name;
    for (const std::string& severity : severities()) {
      const Pipeline p = readPipeline(quickstart, {"corruption={" + name + ": " + severity + "}"});
      const auto options = [&](const Pipeline& of) {
        std::string all;
        for (const ChosenEffect& effect : *of.sensors.front().effects) all += effect.options + "\n";
        return all;
      };
      EXPECT_NE(options(p), options(clean)) << name;
    }
  }
}

TEST(Corruption, NullIsNone) {
  const std::filesystem::path quickstart = std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines/quickstart.yaml";
  EXPECT_EQ(readPipeline(quickstart, {"corruption=null"}).sensors.front().effects->size(),
            readPipeline(quickstart, {}).sensors.front().effects->size());
  EXPECT_TRUE(readPipeline(quickstart, {"effects=null"}).sensors.front().effects->empty());
}

TEST(Corruption, OfOnesOwnIsAFile) {
  const TemporaryFolder folder;
  folder.write("mud.yaml", "summary: mud\nlight: [quantize: {step_m: 1}]\nmoderate: [none]\nheavy: [none]\n");
  Value corruption = parseYaml("{mud.yaml: light}", (folder.path() / "pipeline.yaml").string());
  EXPECT_EQ(flowText(withCorruption({}, corruption)), "[{quantize: {step_m: 1}}]");
  folder.write("mud.yaml", "summary: mud\nlight: [quantize: {step_m: 1}]\n");
  EXPECT_THAT(messageOf([&] { return withCorruption({}, corruption); }),
              AllOf(HasSubstr("mud.yaml"), HasSubstr("moderate")));
}

TEST(Corruption, RefusesWhatIsNone) {
  EXPECT_THAT(messageOf([] { corrupted("", "fog"); }), AllOf(HasSubstr("y.yaml:1:"), HasSubstr("{fog: heavy}")));
  EXPECT_THAT(messageOf([] { corrupted("", "{fog: strong}"); }), HasSubstr("moderate"));
  EXPECT_THAT(messageOf([] { corrupted("", "{smog: heavy}"); }), HasSubstr("fog"));
  EXPECT_THAT(messageOf([] { corrupted("", "{hdl_64e.yaml: heavy}"); }), HasSubstr("y.yaml"));
}

// Things lose returns, and nothing else does.
class CorruptedYard : public Yard {};

TEST_F(CorruptedYard, IncompleteEchoesAreOfThings) {
  const Manifest whole = sound({}, "whole");
  const Manifest less = sound({"corruption={incomplete_echo: heavy}"}, "less");
  std::uint64_t cars = 0;
  std::uint64_t left = 0;
  for (std::size_t i = 0; i < whole.samples.size(); ++i) {
    auto before = whole.samples[i].scans[0].pointsPerClass;
    auto after = less.samples[i].scans[0].pointsPerClass;
    const std::uint16_t car = whole.ontology.require("car", {}).id;
    cars += before[car];
    left += after[car];
    before.erase(car);
    after.erase(car);
    EXPECT_EQ(before, after);
  }
  EXPECT_GT(cars, 20U);
  EXPECT_LT(left, cars / 3);
  EXPECT_THAT(less.pipelineText, HasSubstr("corruption={incomplete_echo: heavy}"));
}

}  // namespace
}  // namespace scanmill
