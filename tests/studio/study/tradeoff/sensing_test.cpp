#include "pipeline/scenes/shot_source.h"
#include "study/tradeoff/study.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

const std::string kWide =
    "sensors=[{name: top, columns: 512, rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 32}, range_m: [0.5, "
    "100], mount: {position: [0, 0, 1.8]}, divergence_mrad: 12, pulse_ns: 20}]";

class SensingStudyTest : public Yard {
 protected:
  std::vector<SensingResult> measured(const std::string& effects, const std::function<bool()>& stop = {}) const {
    const Plan plan = makePlan(readPipeline(pipeline_, {kWide, "effects=" + effects}));
    ShotSource source(plan);
    const Scene scene = source.load(0);
    return measureSensing(plan, scene, source.frame(0, 1).shots, {}, stop);
  }

  static const SensingResult& named(const std::vector<SensingResult>& results, const std::string& name) {
    for (const SensingResult& r : results) {
      if (r.name == name) return r;
    }
    throw Error("no setting " + name);
  }
};

TEST_F(SensingStudyTest, MoreRaysComeNearerToTheTruth) {
  const auto results = measured("[intensity, footprint: {rays: 7}, range_noise: {sigma_m: 1}]");
  ASSERT_EQ(results.size(), 8u);
  EXPECT_THAT(results[0].name, HasSubstr("127 rays"));
  EXPECT_EQ(results[0].missing + results[0].added, 0u);
  EXPECT_EQ(results[0].distance.max, 0);
  EXPECT_EQ(results[0].sameClass, results[0].both);
  double wrong = INFINITY;  // beams of another class
  const SensingResult& most = named(results, "91 rays a beam");
  const SensingResult& own = results.back();
  EXPECT_EQ(own.name, "as the pipeline is");
  EXPECT_EQ(own.missing, named(results, "7 rays a beam").missing);
  EXPECT_EQ(own.distance.mean, named(results, "7 rays a beam").distance.mean);
  for (std::size_t i = 1; &results[i] != &own; ++i) {
    EXPECT_EQ(results[i].failure, "");
    EXPECT_EQ(results[i].beams, 512u * 32u);
    const auto other = static_cast<double>(results[i].both - results[i].sameClass);
    EXPECT_LT(other, 1.1 * wrong + 3) << results[i].name;
    wrong = other;
    EXPECT_LE(results[i].both + results[i].missing + results[i].added, results[i].beams);
  }
  EXPECT_LT(most.distance.mean, 0.25 * results[1].distance.mean);
  EXPECT_LT(wrong, 0.25 * static_cast<double>(results[1].both - results[1].sameClass));
  EXPECT_LT(results[1].distance.mean, 0.5) << "noise of a metre is left out";
  EXPECT_GT(results[0].traceSeconds, results[1].traceSeconds);
}

TEST_F(SensingStudyTest, ClearAirReturnsWhatWeatherHides) {
  const auto results = measured("[intensity, dropout: {threshold: 0.0008}, weather: {kind: dust, visibility_m: 40}]");
  ASSERT_EQ(results.size(), 2u);
  const SensingResult& clear = named(results, "clear air");
  EXPECT_EQ(clear.missing, 0u);
  EXPECT_GT(clear.added + (clear.both - clear.sameClass), clear.beams / 20);
  EXPECT_GT(clear.intensity, 0);
}

TEST_F(SensingStudyTest, IsEmptyWhereNothingCanBeLeftOut) {
  EXPECT_TRUE(measured("[intensity, dropout: {probability: 0.1}, range_noise: {sigma_m: 0.01}]").empty());
}

// The sensor's own list stands where the pipeline says `sensor`.
TEST_F(SensingStudyTest, KnowsTheSensorsOwnEffects) {
  const std::string own = kWide.substr(0, kWide.size() - 2) + ", effects: [intensity, footprint: {rays: 7}]}]";
  const Plan plan = makePlan(readPipeline(pipeline_, {own, "effects=[sensor, light_paths]"}));
  ShotSource source(plan);
  const Scene scene = source.load(0);
  std::vector<std::string> said;
  const auto results =
      measureSensing(plan, scene, source.frame(0, 0).shots, [&](const std::string& name) { said.push_back(name); }, {});
  ASSERT_EQ(results.size(), 12u);
  EXPECT_THAT(results[0].name, HasSubstr("2 mirrors, 8 panes"));
  EXPECT_EQ(said.size(), results.size());
  for (const SensingResult& r : results) EXPECT_EQ(r.failure, "") << r.name;
}

TEST_F(SensingStudyTest, IsStopped) {
  EXPECT_THROW(measured("[intensity, footprint: {rays: 7}]", [] { return true; }), Error);
}

}  // namespace
}  // namespace scanmill
