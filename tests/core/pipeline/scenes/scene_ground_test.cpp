#include "drive_world.h"
#include "pipeline/scenes/scene_probe.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class SceneGrounds : public testing::Test {
 protected:
  TemporaryFolder folder_;
  Scene scene_ = readRoadScene(folder_);
};

TEST_F(SceneGrounds, UnderAPlaceIsTheHighestBelowOrTheLowestAbove) {
  const SceneGround ground(scene_, {});
  EXPECT_NEAR(*ground.under({20, -40, 8}), 6, 1e-5);     // on the bridge
  EXPECT_NEAR(*ground.under({20, -40, 3}), 0, 1e-5);     // beneath it
  EXPECT_NEAR(*ground.under({20, -40, -0.3}), 0, 1e-5);  // not more than half a metre above
  EXPECT_NEAR(*ground.under({0, 0, -50}), -0.1, 1e-5);
  EXPECT_NEAR(*ground.under({0, -42.5, 30}), 0, 1e-5) << "no vehicle stands on a car";
  EXPECT_FALSE(ground.under({500, 0, 0}).has_value());
}

TEST_F(SceneGrounds, NearAPlaceIsTheNearestInHeight) {
  const SceneGround ground(scene_, {});
  EXPECT_NEAR(*ground.near({20, -40, 6.7}), 6, 1e-5);
  EXPECT_NEAR(*ground.near({20, -40, 0.9}), 0, 1e-5);
  EXPECT_FALSE(ground.near({20, -40, 3}).has_value());
}

TEST_F(SceneGrounds, OfCertainClassesIsNothingElse) {
  const auto ids = [&](const std::vector<std::string>& names) {
    return classIds(scene_.ontology, names, {"trip.yaml", 3, 4});
  };
  const SceneGround road(scene_, ids({"road"}));
  EXPECT_NEAR(*road.under({20, -40, 8}), 0, 1e-5);
  EXPECT_FALSE(road.under({0, 0, 3}).has_value());
  EXPECT_NEAR(*SceneGround(scene_, ids({"terrain", "road"})).under({0, 0, 3}), -0.1, 1e-5);
  EXPECT_THAT(messageOf([&] { ids({"raod"}); }), testing::AllOf(HasSubstr("trip.yaml:3:4"), HasSubstr("'road'")));
}

}  // namespace
}  // namespace scanmill
