#include "pipeline/scenes/scene_probe.h"

#include "drive_world.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class SceneGrounds : public testing::Test {
 protected:
  TemporaryFolder folder_;
  Scene scene_ = readRoadScene(folder_);
  SceneProbe probe_{scene_};
};

TEST_F(SceneGrounds, ProbesMeetWhatIsFirstAndAllThatIsBehind) {
  const SceneProbe::Ray down{{20, -40, 20}, {0, 0, -1}};
  const auto hit = probe_.first(down, 100);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->distance, 14, 1e-5);
  EXPECT_NEAR(hit->position.z, 6, 1e-5);
  EXPECT_NEAR(hit->normal.z, 1, 1e-6);
  EXPECT_FALSE(probe_.first(down, 13.9).has_value());
  std::vector<double> heights;
  for (const SceneProbe::Hit& m : probe_.all({down}, 100).front()) heights.push_back(m.position.z);
  EXPECT_THAT(heights, testing::Pointwise(testing::DoubleNear(1e-5), {6.0, 5.5, 0.0, -0.1}));
}

TEST_F(SceneGrounds, ManyRaysMeetWhatEachMeetsAlone) {
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
TEST_F(SceneGrounds, FarRaysMeetWhatNearOnesMeet) {
  const SceneProbe::Ray down{{20, -40, 20}, {0, 0, -1}};
  const auto near = probe_.all({down}, 100).front();
  for (const double far : {1e3, 1e5}) {
    const auto hit = probe_.all({{down.from + Vec3d{0, 0, far}, down.direction}}, 1e6).front();
    ASSERT_EQ(hit.size(), near.size());
    for (std::size_t i = 0; i < hit.size(); ++i) EXPECT_NEAR(hit[i].distance - far, near[i].distance, 1e-7 * far);
  }
  EXPECT_FALSE(probe_.first(SceneProbe::Ray{{20, -40, 1e5}, {0, 0, 1}}, 1e6).has_value());
  EXPECT_FALSE(probe_.first(SceneProbe::Ray{{1e5, -40, 20}, {0, 0, -1}}, 1e6).has_value());
  EXPECT_FALSE(probe_.first(SceneProbe::Ray{{1e5, -40, 20}, {0, 1, 0}}, 1e6).has_value());
}

TEST_F(SceneGrounds, UnderAPlaceIsTheHighestBelowOrTheLowestAbove) {
  const SceneGround ground(probe_, {});
  EXPECT_NEAR(*ground.under({20, -40, 8}), 6, 1e-5);     // on the bridge
  EXPECT_NEAR(*ground.under({20, -40, 3}), 0, 1e-5);     // beneath it
  EXPECT_NEAR(*ground.under({20, -40, -0.3}), 0, 1e-5);  // not more than half a metre above
  EXPECT_NEAR(*ground.under({0, 0, -50}), -0.1, 1e-5);
  EXPECT_NEAR(*ground.under({0, -42.5, 30}), 0, 1e-5) << "no vehicle stands on a car";
  EXPECT_FALSE(ground.under({500, 0, 0}).has_value());
}

TEST_F(SceneGrounds, AroundPointsAreAllHeightsWithinReach) {
  const SceneGround ground(probe_, {});
  const auto heights = ground.around({{20, -40, 6.7}, {20, -40, 0.9}, {20, -40, 3}, {500, 0, 0}}, 1.5);
  const auto near = [](double z) { return testing::DoubleNear(z, 1e-5); };
  EXPECT_THAT(heights[0], testing::ElementsAre(near(6), near(5.5)));  // on the bridge
  EXPECT_THAT(heights[1], testing::ElementsAre(near(0), near(-0.1)));
  EXPECT_THAT(heights[2], testing::IsEmpty());
  EXPECT_THAT(heights[3], testing::IsEmpty());
}

TEST_F(SceneGrounds, OfCertainClassesIsNothingElse) {
  const auto ids = [&](const std::vector<std::string>& names) {
    return classIds(scene_.ontology, names, {"trip.yaml", 3, 4});
  };
  const SceneGround road(probe_, ids({"road"}));
  EXPECT_NEAR(*road.under({20, -40, 8}), 0, 1e-5);
  EXPECT_FALSE(road.under({0, 0, 3}).has_value());
  EXPECT_NEAR(*SceneGround(probe_, ids({"terrain", "road"})).under({0, 0, 3}), -0.1, 1e-5);
  EXPECT_THAT(messageOf([&] { ids({"raod"}); }), testing::AllOf(HasSubstr("trip.yaml:3:4"), HasSubstr("'road'")));
}

}  // namespace
}  // namespace scanmill
