#include <cstdlib>

#include "formats/cloud_file.h"
#include "pipeline/scenes/scene_probe.h"
#include "scenefile/scene_file.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

// A real revolution, looked at from where it was recorded: rays to its points meet surfaces at their ranges, but for
// those that a neighbour's square, nearer at an edge, stands in front of.
TEST(CloudScenes, OfARealRevolutionAreMetAtItsRanges) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 1);
  const Scene scene = readScene(SCANMILL_SOURCE_DIR "/tests/data/scenes/recorded_place.yaml", {});
  const Cloud cloud = readCloud(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd");
  const SceneProbe probe(scene);
  std::vector<SceneProbe::Ray> rays;
  std::vector<double> exact;
  for (std::size_t i = 0; i < cloud.scan.size(); i += 7) {
    const Vec3d p(cloud.scan.position[i]);
    if (!isFinite(p) || length(p) < 0.5) continue;
    rays.push_back({{0, 0, 0}, normalized(p)});
    exact.push_back(length(p));
  }
  const auto met = probe.first(rays, 500);
  std::vector<double> off;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    off.push_back(met[i] ? std::fabs(met[i]->distance - exact[i]) : 500);
  }
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() / 2], 0.025);
  EXPECT_LT(off[off.size() * 8 / 10], 0.13);
  EXPECT_LT(off.back(), 500) << "every one meets something";
}

}  // namespace
}  // namespace scanmill
