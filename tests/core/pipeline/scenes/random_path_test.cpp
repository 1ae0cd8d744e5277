#include "base/path.h"
#include "drive_world.h"
#include "pipeline/scenes/scene_probe.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Side = RoadSide;

// How far a place is from the middle of the road: that of the square, outwards.
double outwards(const Vec3d& p) {
  return std::max(std::fabs(p.x), std::fabs(p.y)) - 40;
}

class RandomPath : public testing::Test {
 protected:
  Path way(double length, const std::string& name = "drive", Side keep = Side::Right, std::uint64_t seed = 1) const {
    return Path(findRandomPath(probe_, {{"road"}, keep, length, 0, {"trip.yaml", 3, 4}}, seed, name));
  }

  TemporaryFolder folder_;
  Scene scene_ = readRoadScene(folder_);
  SceneProbe probe_{scene_};
};

TEST_F(RandomPath, StayOnTheRoadAndClearOfWhatStandsThere) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Path path = way(600, "drive", Side::Right, seed);
    EXPECT_GT(path.length(), 595) << seed;
    for (double at = 0; at < path.length(); at += 0.5) {
      const Pose pose = path.pose(at);
      EXPECT_LT(std::fabs(outwards(pose.translation)), 3.5) << seed << ": " << at;
      EXPECT_NEAR(pose.translation.z, 0, 1e-3);
      const Vec3d fromCar = pose.translation - Vec3d{0, -42.5, 0};
      EXPECT_TRUE(std::fabs(fromCar.x) > 2 || std::fabs(fromCar.y) > 1.7) << seed << ": " << at;
      EXPECT_LT(std::fabs(path.curvature(at, 1)), 1 / 3.5) << seed << ": " << at;
    }
  }
}

// On the straight parts, away from the car: 2 m from the edge, whichever way around, or in the middle.
TEST_F(RandomPath, KeepToTheirSide) {
  const auto meanOff = [&](Side keep, std::uint64_t seed) {
    const Path path = way(500, "drive", keep, seed);
    double sum = 0;
    int count = 0;
    for (double at = 0; at < path.length(); at += 1) {
      const Pose pose = path.pose(at);
      const Vec3d& p = pose.translation;
      if (std::min(std::fabs(p.x), std::fabs(p.y)) > 25 || p.y < -30) continue;
      // Where it drives, seen along its heading: positive is to the right.
      const Vec3d right = -toMatrix(pose.rotation).y;
      const Vec3d out =
          std::fabs(p.x) > std::fabs(p.y) ? Vec3d{std::copysign(1.0, p.x), 0, 0} : Vec3d{0, std::copysign(1.0, p.y), 0};
      sum += outwards(p) * (dot(right, out) > 0 ? 1 : -1);
      ++count;
    }
    return sum / count;
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    EXPECT_NEAR(meanOff(Side::Right, seed), 2, 0.7) << seed;
    EXPECT_NEAR(meanOff(Side::Left, seed), -2, 0.7) << seed;
    EXPECT_NEAR(meanOff(Side::Middle, seed), 0, 0.5) << seed;
  }
}

TEST_F(RandomPath, FollowFromSeedAndName) {
  const auto places = [&](const std::string& name, std::uint64_t seed) {
    return findRandomPath(probe_, {{"road"}, Side::Right, 200, {}}, seed, name);
  };
  EXPECT_EQ(places("a", 1), places("a", 1));
  EXPECT_NE(places("a", 1), places("a", 2));
  EXPECT_NE(places("a", 1), places("b", 1));
}

// Walls make two roads of one; neither is left.
TEST_F(RandomPath, DoNotGoThroughWallsNorUnderWhatIsLow) {
  const Scene walled = readRoadScene(
      folder_,
      "  - {name: wall, primitive: box, size: [0.2, 20, 3], class: wall, material: brick, position: [10, 40, 1.5]}\n"
      "  - {name: beam, primitive: box, size: [1, 20, 0.5], class: structure, material: concrete, position: [-10, -40, "
      "2.65]}\n");
  const SceneProbe probe(walled);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Path path(findRandomPath(probe, {{"road"}, Side::Right, 100, {}}, seed, "drive"));
    Vec3d before = path.pose(0).translation;
    for (double at = 0.1; at < path.length(); at += 0.1) {
      const Vec3d now = path.pose(at).translation;
      EXPECT_FALSE(now.y > 30 && (before.x - 10) * (now.x - 10) < 0) << seed;
      EXPECT_FALSE(now.y < -30 && std::fabs(now.x + 10) < 0.5) << seed;
      before = now;
    }
  }
}

// 2.6 m are enough.
TEST_F(RandomPath, GoUnderWhatIsHigh) {
  const Scene beamed = readRoadScene(
      folder_,
      "  - {name: beam, primitive: box, size: [1, 20, 0.5], class: structure, material: concrete, position: [-10, -40, "
      "2.85]}\n");
  const SceneProbe probe(beamed);
  bool under = false;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Path path(findRandomPath(probe, {{"road"}, Side::Right, 400, {}}, seed, "drive"));
    for (double at = 0; at < path.length(); at += 0.1) {
      const Vec3d p = path.pose(at).translation;
      under = under || (p.y < -30 && std::fabs(p.x + 10) < 0.5);
    }
  }
  EXPECT_TRUE(under);
}

TEST_F(RandomPath, SayWhatIsTooShortOrNotThere) {
  const Scene dead = readRoadScene(
      folder_,
      "  - {name: wall, primitive: box, size: [0.2, 20, 3], class: wall, material: brick, position: [10, 40, 1.5]}\n");
  const SceneProbe probe(dead);
  // Once around the square is 320 m; from one side of the wall to the other a little less.
  EXPECT_THAT(messageOf([&] {
                findRandomPath(probe, {{"road"}, Side::Right, 500, 0, {"trip.yaml", 3, 4}}, 1, "drive");
              }),
              AllOf(HasSubstr("trip.yaml:3:4"), HasSubstr("longest drive"), HasSubstr("500 m are needed"),
                    testing::Not(HasSubstr("unit"))));
  Scene tiny = scene_;
  const Affine centimetres{Mat3{{0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}}, {}};
  for (Instance& instance : tiny.instances) instance.worldFromMesh = centimetres * instance.worldFromMesh;
  EXPECT_THAT(messageOf([&] {
                findRandomPath(SceneProbe(tiny), {{"road"}, Side::Right, 5, {}}, 1, "drive");
              }),
              HasSubstr("m: is its `unit` right?"));
  EXPECT_THAT(messageOf([&] {
                findRandomPath(probe_, {{"parking"}, Side::Right, 5, {}}, 1, "drive");
              }),
              HasSubstr("no surface of parking"));
  EXPECT_THAT(messageOf([&] {
                findRandomPath(probe_, {{"raod"}, Side::Right, 5, 0, {"trip.yaml", 3, 4}}, 1, "drive");
              }),
              HasSubstr("did you mean 'road'"));
}

}  // namespace
}  // namespace scanmill
