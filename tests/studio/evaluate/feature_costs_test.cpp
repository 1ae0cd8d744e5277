#include "evaluate/feature_costs.h"

#include <cmath>

#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::Contains;
using testing::Each;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class FeaturesOfYard : public Yard {
 protected:
  FeatureCosts costs(const std::vector<std::string>& overrides, int repeats = 1) const {
    return measureFeatures(readPipeline(pipeline_, overrides), {.rounds = repeats});
  }

  static std::vector<std::string> names(const FeatureCosts& costs, bool present) {
    std::vector<std::string> names;
    for (const FeatureCost& f : costs.features) {
      if (f.present == present) names.push_back(f.feature);
    }
    return names;
  }

  static const FeatureCost& feature(const FeatureCosts& costs, const std::string& name) {
    for (const FeatureCost& f : costs.features) {
      if (f.feature == name) return f;
    }
    throw Error("no feature " + name);
  }

  // Of the middle frame's scans, as generate() writes them.
  double written(std::vector<std::string> overrides, const std::string& name) const {
    run(overrides, name);
    double bytes = 0;
    for (const auto& [member, content] : members(name)) {
      if (member.starts_with("yard-s1-drive-000002.") && !member.ends_with(".json")) {
        bytes += static_cast<double>(content.size());
      }
    }
    return bytes;
  }
};

const std::vector<std::string> kNoisy{
    "effects=[intensity, {dropout: {probability: 0.01}}, {range_noise: {sigma_m: 0.01}}]",
    "output={columns: [intensity, label, ring, time], formats: [pcd, {draco: {max_error_mm: 1}}]}"};

// What an effect sets goes with it: a scan without it is still made.
TEST_F(FeaturesOfYard, GoWithWhatTheyLookAt) {
  const std::string wide = std::string(kTop).insert(1, "divergence_mrad: 3, pulse_ns: 5, ");
  const FeatureCosts all = costs({"sensors=[" + wide + "]",
                                  "effects=[{speckle: {looks: 4}}, {footprint: {rays: 7}}, {light_paths: {}}, "
                                  "intensity, {detection: {noise: 0.001}}, {range_noise: {over_snr_m: 0.1}}]"});
  for (const char* name :
       {"effect speckle", "effect footprint", "effect light_paths", "effect intensity and detection and range_noise",
        "effect detection and range_noise", "effect range_noise"}) {
    EXPECT_THAT(names(all, true), Contains(name));
  }
  EXPECT_GT(feature(all, "effect footprint").cost.traceSeconds, 0);
}

TEST_F(FeaturesOfYard, NamesEveryEffectColumnAndFormat) {
  const FeatureCosts all = costs(kNoisy);
  EXPECT_EQ(all.frame, "yard-s1-drive-000002");
  const std::vector<std::string> there = names(all, true);
  for (const char* name :
       {"effect range_noise", "column label", "column ring", "column time", "format pcd", "format draco"}) {
    EXPECT_THAT(there, Contains(name));
  }
  EXPECT_THAT(there, Contains(StartsWith("effect intensity")));
  EXPECT_THAT(there, Contains(StartsWith("effect dropout")));
  const std::vector<std::string> absent = names(all, false);
  for (const char* name : {"column instance", "column column", "column range_true", "column incidence", "ego motion"}) {
    EXPECT_THAT(absent, Contains(name));
  }
  EXPECT_THAT(there, Not(Contains("alpha cut-outs"))) << "no material has one";
  EXPECT_THAT(names(costs({"motion=per_column"}), true), Contains("ego motion"));
  EXPECT_THAT(names(costs({}), true), Not(Contains(StartsWith("format")))) << "there is but one";
}

TEST_F(FeaturesOfYard, NothingIsUnknown) {
  const FeatureCosts all = costs(kNoisy, 2);
  const auto finite = [](const FrameCost& c) {
    return std::isfinite(c.traceSeconds) && std::isfinite(c.effectsSeconds) && std::isfinite(c.encodeSeconds) &&
           std::isfinite(c.bytes);
  };
  EXPECT_TRUE(finite(all.whole));
  EXPECT_GT(all.whole.traceSeconds, 0);
  EXPECT_GT(all.whole.effectsSeconds, 0);
  EXPECT_GT(all.whole.encodeSeconds, 0);
  for (const FeatureCost& f : all.features) {
    EXPECT_TRUE(finite(f.cost)) << f.feature;
    EXPECT_GE(f.scatter, 0) << f.feature;
  }
}

// To the byte what generate() writes with and without.
TEST_F(FeaturesOfYard, BytesAreThoseOfTheDatasets) {
  const FeatureCosts all = costs(kNoisy);
  const double whole = written(kNoisy, "whole");
  EXPECT_EQ(all.whole.bytes, whole);
  for (const auto& [name, columns] : {std::pair{"column time", "[intensity, label, ring]"},
                                      {"column label", "[intensity, ring, time]"},
                                      {"column instance", "[intensity, label, instance, ring, time]"},
                                      {"column column", "[intensity, label, ring, column, time]"},
                                      {"column incidence", "[intensity, label, ring, time, incidence]"}}) {
    std::vector<std::string> other = kNoisy;
    other.push_back(fmt::format("output.columns={}", columns));
    const FeatureCost& f = feature(all, name);
    const double difference = written(other, name) - whole;
    EXPECT_EQ(f.cost.bytes, f.present ? -difference : difference) << name;
    EXPECT_GT(f.cost.bytes, 0) << name;
  }
  std::vector<std::string> draco = kNoisy;
  draco.emplace_back("output.formats=[{draco: {max_error_mm: 1}}]");
  EXPECT_EQ(feature(all, "format pcd").cost.bytes, whole - written(draco, "draco"));
}

// Each sensor's own effects are taken out of all of them.
TEST_F(FeaturesOfYard, EffectsOfSensorsCountOnce) {
  const std::string tail = "rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 4}, range_m: [0.5, 100]";
  const std::vector<std::string> own{
      fmt::format("sensors=[{{name: a, columns: 64, {0}, effects: [intensity, {{range_noise: {{sigma_m: 0.02}}}}]}}, "
                  "{{name: b, columns: 32, {0}, effects: [{{range_noise: {{sigma_m: 0.01}}}}, intensity, "
                  "{{angular_jitter: {{sigma_deg: 0.1}}}}]}}]",
                  tail),
      "effects=sensor"};
  const FeatureCosts all = costs(own);
  std::vector<std::string> effectNames;
  for (const std::string& name : names(all, true)) {
    if (name.starts_with("effect ")) effectNames.push_back(name);
  }
  EXPECT_THAT(effectNames,
              testing::UnorderedElementsAre("effect intensity", "effect range_noise", "effect angular_jitter"));
  EXPECT_EQ(all.whole.bytes, written(own, "own"));
  std::vector<std::string> unlit = own;
  unlit[0] = fmt::format(
      "sensors=[{{name: a, columns: 64, {0}, effects: [{{range_noise: {{sigma_m: 0.02}}}}]}}, "
      "{{name: b, columns: 32, {0}, effects: [{{range_noise: {{sigma_m: 0.01}}}}, {{angular_jitter: {{sigma_deg: "
      "0.1}}}}]}}]",
      tail);
  EXPECT_EQ(feature(all, "effect intensity").cost.bytes, written(own, "lit") - written(unlit, "unlit"));
}

}  // namespace
}  // namespace scanmill
