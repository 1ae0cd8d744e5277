#include "pipeline/scenes/scene_probe.h"

#include "drive_world.h"

namespace scanmill {
namespace {

class SceneProbes : public testing::Test {
 protected:
  TemporaryFolder folder_;
  Scene scene_ = readRoadScene(folder_);
  SceneProbe probe_{scene_};
};

TEST_F(SceneProbes, MeetWhatIsFirst) {
  const SceneProbe::Ray down{{20, -40, 20}, {0, 0, -1}};
  const auto hit = probe_.first(down, 100);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->distance, 14, 1e-5);
  EXPECT_NEAR(hit->position.z, 6, 1e-5);
  EXPECT_NEAR(hit->normal.z, 1, 1e-6);
  EXPECT_FALSE(probe_.first(down, 13.9).has_value());
}

TEST_F(SceneProbes, ManyRaysMeetWhatEachMeetsAlone) {
  std::vector<SceneProbe::Ray> rays;
  for (int i = 0; i < 200; ++i) {
    rays.push_back({{0.5 * i - 50, 0.37 * i - 40, 10}, normalized(Vec3d{0.01 * i - 1, 0.3, -0.5})});
  }
  const auto together = probe_.first(rays, 80);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto alone = probe_.first(rays[i], 80);
    ASSERT_EQ(together[i].has_value(), alone.has_value()) << i;
    if (!alone) continue;
    EXPECT_NEAR(together[i]->distance, alone->distance, 1e-4) << i;
    EXPECT_EQ(together[i]->semantic, alone->semantic) << i;
  }
}

// Rays end with the scene, however far they are asked to go, and from wherever they come.
TEST_F(SceneProbes, FarRaysMeetWhatNearOnesMeet) {
  const SceneProbe::Ray down{{20, -40, 20}, {0, 0, -1}};
  const auto near = probe_.first(down, 100);
  for (const double far : {1e3, 1e5}) {
    const auto hit = probe_.first(SceneProbe::Ray{down.from + Vec3d{0, 0, far}, down.direction}, 1e6);
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR(hit->distance - far, near->distance, 1e-7 * far);
  }
  EXPECT_FALSE(probe_.first(SceneProbe::Ray{{20, -40, 1e5}, {0, 0, 1}}, 1e6).has_value());
  EXPECT_FALSE(probe_.first(SceneProbe::Ray{{1e5, -40, 20}, {0, 0, -1}}, 1e6).has_value());
  EXPECT_FALSE(probe_.first(SceneProbe::Ray{{1e5, -40, 20}, {0, 1, 0}}, 1e6).has_value());
}

}  // namespace
}  // namespace scanmill
