// The pipelines that come with the program, cut to one frame.

#include <cstdlib>

#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/blender.h"
#include "tests/support/gl.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

// The file of a pipeline of the program, or of one whose assets are not part of the project.
std::filesystem::path pipelineFile(const std::string& name) {
  const std::filesystem::path source(SCANMILL_SOURCE_DIR);
  return exists(source / "pipelines" / name) ? source / "pipelines" / name : source / "tests/data/pipelines" / name;
}

// Generates, verifies, and expects every point to have a class that is not `unlabeled`.
Manifest generateLabelled(const std::string& pipeline, const std::vector<std::string>& overrides,
                          std::size_t leastClasses) {
  const TemporaryFolder folder;
  const GenerateOptions options{.folder = folder.path() / "out", .quiet = true};
  const Plan plan = makePlan(readPipeline(pipelineFile(pipeline), overrides));
  const GenerateSummary summary = generate(plan, options);
  const Verification verification = verifyDataset(options.folder);
  EXPECT_THAT(verification.problems, IsEmpty());
  EXPECT_GT(static_cast<double>(summary.points), 0.5 * static_cast<double>(summary.beams));
  EXPECT_EQ(summary.pointsPerClass.count(0), 0u) << "unlabelled points";
  std::uint64_t labelled = 0;
  for (const auto& [id, count] : summary.pointsPerClass) {
    EXPECT_NE(summary.manifest.ontology.find(id), nullptr) << id;
    labelled += count;
  }
  EXPECT_EQ(labelled, summary.points);
  EXPECT_GE(summary.pointsPerClass.size(), leastClasses);
  return summary.manifest;
}

TEST(Shipped, Street) {
  const Manifest m = generateLabelled("street.yaml", {"scenes.0.seeds=[1]", "splits=", "trajectories.0.frames=1"}, 10);
  EXPECT_EQ(m.samples.front().scans.front().beams, 64u * 2048u);
  EXPECT_GT(m.samples.front().scans.front().instances, 5u);
}

// As a real sensor sees it, whatever it takes for a return. What comes from nothing has no class.
TEST(Shipped, Quickstart) {
  const TemporaryFolder folder;
  const GenerateOptions options{.folder = folder.path() / "out", .quiet = true};
  const Plan plan = makePlan(readPipeline(std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines/quickstart.yaml",
                                          {"splits=", "trajectories.0.frames=1", "trajectories.1.frames=1"}));
  const GenerateSummary summary = generate(plan, options);
  EXPECT_THAT(verifyDataset(options.folder).problems, IsEmpty());
  EXPECT_GE(summary.pointsPerClass.size(), 20u);
  ReasonCounts beams;
  for (const SampleRecord& sample : summary.manifest.samples) {
    for (const auto& [reason, count] : sample.scans.at(0).beamsPerReason) beams[reason] += count;
  }
  const auto share = [&](Reason reason) {
    return static_cast<double>(beams[static_cast<std::uint8_t>(reason)]) / static_cast<double>(summary.beams);
  };
  // Real scans of such a sensor: 87 to 89 % of the beams return, and the ego vehicle hides a third of the lowest rings.
  EXPECT_NEAR(static_cast<double>(summary.points) / static_cast<double>(summary.beams), 0.88, 0.06);
  EXPECT_GT(share(Reason::EgoVehicle) + share(Reason::BlockedByVehicle), 0.03);
  EXPECT_GT(share(Reason::ThroughGlass), 0.005);
  EXPECT_GT(share(Reason::TooFaint), 0.001);
  EXPECT_LT(share(Reason::FalsePositive), 0.001);
}

// Sets of others, noise-free and a frame each: all of it labelled, nothing amiss with sensors and ways.
struct ThirdParty {
  const char* set;
  std::vector<std::string> overrides;
  std::size_t leastClasses;
};

class ShippedSets : public testing::TestWithParam<ThirdParty> {};

TEST_P(ShippedSets, AreLabelledAndDrivenThrough) {
  const ThirdParty& set = GetParam();
  SKIP_WITHOUT_SHARED_DATA(std::string("scenes/") + set.set);
  if (std::string(set.set) == "blender") {
    SKIP_WITHOUT_BLENDER();
  }
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 1);
  std::vector<std::string> overrides = set.overrides;
  overrides.insert(overrides.end(), {"effects=[intensity]", "motion=none", "output.formats=[pcd]"});
  generateLabelled(std::string(set.set) + ".yaml", overrides, set.leastClasses);
  const Plan plan = makePlan(readPipeline(pipelineFile(std::string(set.set) + ".yaml"), {}));
  ShotSource source(plan);
  const Scene scene = source.load(0);
  EXPECT_TRUE(scene.unlabeled.empty());
  EXPECT_THAT(ruleWarnings(scene), IsEmpty());
  const SceneProbe probe(scene);
  for (std::size_t s = 0; s < plan.pipeline.sequences.size(); ++s) {
    EXPECT_THAT(pathWarnings(source, s, probe), IsEmpty());
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, ShippedSets,
    testing::Values(ThirdParty{"kenney_city", {"trajectories.0.frames=1", "trajectories.1.frames=1"}, 7},
                    ThirdParty{"gazebo", {"trajectories.0.frames=2"}, 12},
                    ThirdParty{"torcs_dirt4", {"trajectories.0.frames=1"}, 3},
                    ThirdParty{"helios", {"trajectories.0.frames=3"}, 4}, ThirdParty{"blender", {}, 3}),
    [](const auto& set) { return std::string(set.param.set); });

TEST(Shipped, TruckTown) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town");
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 1);
  const Manifest m = generateLabelled("truck_town.yaml", {"trajectories.0.frames=1"}, 4);
  EXPECT_EQ(m.samples.front().scans.size(), 2u);
}

// SHA-256 of the shards by their names, one for each split.
std::map<std::string, std::string> shardsOf(const std::string& pipeline, std::vector<std::string> overrides) {
  const TemporaryFolder folder;
  overrides.emplace_back("output.shard_samples=1000");
  const Plan plan = makePlan(readPipeline(pipelineFile(pipeline), overrides));
  std::map<std::string, std::string> hashes;
  for (const ShardRecord& shard : generate(plan, {.folder = folder.path() / "out", .quiet = true}).manifest.shards)
    hashes[shard.file] = shard.sha256;
  return hashes;
}

// The same pipeline gives the same bytes for ever, whatever becomes of the code. Who changes them on purpose, such as
// by another street, writes the new digests here and says so in the changelog. Embree uses the instructions that all
// machines have, before any test makes its first hierarchy.
const int kSameInstructions = ::setenv("SCANMILL_ISA", "avx2", 1);

TEST(Shipped, BytesStayTheSame) {
  const std::map<std::string, std::string> street = shardsOf("street.yaml", {});
  EXPECT_EQ(street.at("test/test-000000.tar"), "2b4da059af608f9ded73a9bfc4ea312ca9e877e317381b8236fca89f22c0aa73");
  EXPECT_EQ(street.at("val/val-000000.tar"), "fe504dab025d7d28dd1a90999170713b944323cc627293bbf34d766facae6ee1");
  EXPECT_EQ(street.at("train/train-000000.tar"), "950fbf2c9c6a3336a309673b9c7ee9659e2226e8c78d9f9aede18eb1d23dddba");
  const std::vector<std::string> everything{
      "scenes.0.seeds=[1]",
      "splits=",
      "trajectories.0.frames=4",
      "output.layout=organised",
      "output.formats=[{draco: {time: true}}, pcd, csv]",
      "output.columns=[intensity, label, instance, ring, column, time, range_true, incidence]"};
  EXPECT_EQ(shardsOf("street.yaml", everything),
            (std::map<std::string, std::string>{
                {"train/train-000000.tar", "3a1c3c9e869c220677e03a03a1d8e7f3efb4e5cc26a0995c45a346d8d24e69e8"}}));
}

// And of what a sensor makes of them.
TEST(Shipped, BytesOfTheQuickstartStayTheSame) {
  const std::vector<std::string> few{
      "scenes.0.seeds=[1]", "splits=", "trajectories.0.frames=1", "trajectories.1.frames=1",
      "effects=[sensor, relief, reflectance_variation, light_paths, weather: {kind: rain}]"};
  EXPECT_EQ(shardsOf("quickstart.yaml", few).at("train/train-000000.tar"),
            "4a0f78b73a9925568895cc13f68af3218b071747122c3ede57d07ad7e37a4f9d");
}

TEST(Shipped, BytesOfATownStayTheSame) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town");
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 1);
  EXPECT_EQ(shardsOf("truck_town.yaml", {"trajectories.0.frames=6"}),
            (std::map<std::string, std::string>{
                {"train/train-000000.tar", "ad81d7aae6e59f00758b4e3b8c81581c80091295222f5c693216725f1c099e3a"}}));
}

}  // namespace
}  // namespace scanmill
