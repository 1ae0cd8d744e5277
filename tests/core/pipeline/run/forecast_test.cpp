// Forecasts against what is made. Sizes follow from the pipeline alone; generate prints times beside facts.

#include "pipeline/run/forecast.h"

#include "pipeline/run/recorder.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class ForecastTest : public Yard {
 protected:
  Reread rereadWith(const std::vector<std::string>& overrides) const {
    return [this, overrides](const std::vector<std::string>& more) {
      std::vector<std::string> all = overrides;
      all.insert(all.end(), more.begin(), more.end());
      return readPipeline(pipeline_, all);
    };
  }
  SampleCosts costsOf(const std::vector<std::string>& overrides) const {
    const Reread reread = rereadWith(overrides);
    return measureSampleCosts(makePlan(reread({})), reread);
  }
};

TEST_F(ForecastTest, GrowsWithFramesAndScenes) {
  SampleCosts costs;
  costs.threads = 4;
  costs.cores = 4;
  costs.sceneSeconds = 2;
  costs.slowestSceneSeconds = 1;
  costs.frameSeconds = 0.5;
  costs.frameBytes = 1e6;
  costs.timeSpread = 1.5;
  costs.byteSpread = 1.25;
  const Forecast one = forecast(costs, 100, 1);
  const Forecast two = forecast(costs, 200, 1);
  EXPECT_NEAR(two.seconds.expected - one.seconds.expected, 100 * 0.5 / 4, 1e-9);
  EXPECT_DOUBLE_EQ(two.bytes.expected, 2 * one.bytes.expected);
  EXPECT_DOUBLE_EQ(one.bytes.least * 1.25, one.bytes.expected);
  EXPECT_DOUBLE_EQ(one.bytes.expected * 1.25, one.bytes.most);
  EXPECT_DOUBLE_EQ(one.seconds.expected * 1.5, one.seconds.most);
  // Ten scenes of two processor seconds on four threads; one scene is not faster than all threads set it up.
  EXPECT_NEAR(forecast(costs, 100, 10).seconds.expected - one.seconds.expected, 10 * 2.0 / 4 - 1, 1e-9);
  costs.cores = 2;  // of which each runs two threads
  EXPECT_NEAR(forecast(costs, 100, 10).seconds.expected - one.seconds.expected, 10 * 2.0 / 2 - 1, 1e-9);
}

TEST_F(ForecastTest, CountsEachSeedOfEachSceneOnce) {
  EXPECT_EQ(scenesOf(readPipeline(pipeline_, {})), 1u);
  EXPECT_EQ(scenesOf(readPipeline(pipeline_, {"scenes.0.seeds=[1, 2, 3]"})), 3u);
  const std::string two =
      "trajectories=[{name: a, poses: [{position: [0, 0, 0]}]}, {name: b, poses: [{position: [1, 0, 0]}]}]";
  EXPECT_EQ(scenesOf(readPipeline(pipeline_, {"scenes.0.seeds=[1, 2]", two})), 2u);
}

// The small town itself, with and without boxes, noise and several formats.
TEST_F(ForecastTest, SaysTheSizeOfADataset) {
  const std::vector<std::string> town{
      "scenes=[{scene: " + std::string(SCANMILL_SOURCE_DIR) + "/scenes/hamlet.yaml, seeds: [7]}]",
      "trajectories=[{name: a, along: lane, speed: 8, every_m: 12, frames: 8}]", "sensors.0.columns=512",
      "sensors.0.elevation_deg.rings=32"};
  int number = 0;
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{},
        {"output.objects=true", "output.formats=[pcd: {encoding: binary}, draco, csv]"},
        {"effects=[intensity, {range_noise: {sigma_m: 0.02}}]", "output.reasons=true", "output.layout=organised"}}) {
    std::vector<std::string> overrides = town;
    overrides.insert(overrides.end(), more.begin(), more.end());
    const SampleCosts costs = costsOf(overrides);
    const GenerateSummary made = run(overrides, fmt::format("made{}", number++));
    const Forecast told = forecast(costs, made.samples, 1);
    EXPECT_GT(static_cast<double>(made.bytes), told.bytes.least);
    EXPECT_LT(static_cast<double>(made.bytes), told.bytes.most);
    EXPECT_GT(told.seconds.expected, 0);
    EXPECT_GE(told.threads, 1);
  }
}

TEST_F(ForecastTest, OfARecordingIsThatOfItsOwnSamples) {
  generate(makePlan(readPipeline(pipeline_, {}), channelsThat(&ChannelRow::recorded)),
           {.folder = out("first"), .keepHits = out("hits"), .quiet = true});
  const auto reread = [&](const std::vector<std::string>& more) {
    return readPipeline(pipeline_, more, recordingIn(out("hits")));
  };
  const Plan plan = makePlan(reread({}));
  const SampleCosts costs = measureSampleCosts(plan, reread);
  const GenerateSummary made = generate(plan, {.folder = out("again"), .quiet = true});
  const Forecast told = forecast(costs, made.samples, scenesOf(plan.pipeline));
  EXPECT_GT(static_cast<double>(made.bytes), told.bytes.least);
  EXPECT_LT(static_cast<double>(made.bytes), told.bytes.most);
}

// A tripod's scan of millions of beams is measured on some of its columns.
TEST_F(ForecastTest, OfManyBeamsIsMeasuredOnSome) {
  const SampleCosts some = costsOf({"sensors.0.columns=600", "sensors.0.elevation_deg.rings=500"});
  std::vector<std::string> changed;
  const Reread all = rereadWith({"sensors.0.columns=6000", "sensors.0.elevation_deg.rings=500"});
  const Reread reread = [&](const std::vector<std::string>& more) {
    changed = more;
    return all(more);
  };
  const SampleCosts many = measureSampleCosts(makePlan(all({})), reread);
  EXPECT_THAT(changed, Contains("sensors.0.columns=600"));
  EXPECT_DOUBLE_EQ(many.frameBytes, 10 * some.frameBytes);
}

// The small town has the program's classes; those of the own scenes, vehicle and `labels` are left out of it.
TEST_F(ForecastTest, NeedsNoClassOfTheTown) {
  const std::string own = folder_.write("own.yaml", R"(name: own
source: a test
classes:
  - {id: 0, name: unlabeled, color: [0, 0, 0]}
  - {id: 1, name: ground, color: [1, 0, 0]}
  - {id: 2, name: wall, color: [2, 0, 0]}
  - {id: 3, name: car, color: [3, 0, 0], thing: true}
)");
  std::string scene = yardScene();
  scene.replace(0, scene.find('\n'), "ontology: " + own);
  folder_.write("scenes/yard.yaml", scene);
  EXPECT_GT(costsOf({"vehicle=scenes/yard.yaml"}).frameBytes, 0);
  EXPECT_GT(costsOf({"labels=own.yaml"}).frameBytes, 0);
}

// The small town lacks a class that an effect names.
TEST_F(ForecastTest, SaysWhyThereIsNone) {
  folder_.write("other.yaml",
                "name: other\nsource: a test\nclasses:\n  - {id: 0, name: unlabeled, color: [0, 0, 0]}\n"
                "  - {id: 1, name: drizzle, color: [1, 0, 0]}\n");
  EXPECT_THAT(messageOf<Error>([&] {
                costsOf({"labels=other.yaml", "effects=[intensity, weather: {kind: rain, label: drizzle}]"});
              }),
              HasSubstr("'drizzle'"));
}

}  // namespace
}  // namespace scanmill
