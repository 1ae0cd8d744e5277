// The pipelines that come with the program, cut to one frame.

#include <cstdlib>

#include "tests/pipeline/small_world.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

// Generates, verifies, and expects every point to have a class that is not `unlabeled`.
Manifest generateLabelled(const std::string& pipeline, const std::vector<std::string>& overrides,
                          std::size_t leastClasses) {
  const TemporaryFolder folder;
  GenerateOptions options;
  options.folder = folder.path() / "out";
  options.quiet = true;
  const Plan plan(readPipeline(std::filesystem::path(SCANMILL_SOURCE_DIR) / "pipelines" / pipeline, overrides));
  const GenerateSummary summary = generate(plan, options);
  const Verification verification = verifyDataset(options.folder);
  EXPECT_THAT(verification.problems, testing::IsEmpty());
  EXPECT_GT(static_cast<double>(summary.points), 0.5 * static_cast<double>(summary.rays));
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

TEST(Shipped, Quickstart) {
  const Manifest m =
      generateLabelled("quickstart.yaml", {"scenes.0.seeds=[1]", "splits=", "trajectories.0.frames=1"}, 10);
  EXPECT_EQ(m.samples.front().scans.front().beams, 64u * 2048u);
  EXPECT_GT(m.samples.front().scans.front().instances, 5u);
}

TEST(Shipped, TruckTown) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town");
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 1);
  const Manifest m = generateLabelled("truck_town.yaml", {"trajectories.0.frames=1"}, 4);
  EXPECT_EQ(m.samples.front().scans.size(), 2u);
}

}  // namespace
}  // namespace scanmill
