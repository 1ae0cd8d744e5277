#include "sensors/ground_profile.h"

#include <fmt/format.h>

#include "sensors/trajectory.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// One surface, whose height is a function of the place; nothing where that is NaN.
class Hills : public Ground {
 public:
  using Height = double (*)(double x, double y);
  explicit Hills(Height height) : height_(height) {}
  std::optional<double> under(const Vec3d& p) const override {
    const double z = height_(p.x, p.y);
    return std::isfinite(z) ? std::optional(z) : std::nullopt;
  }
  std::optional<double> near(const Vec3d& p) const override {
    const std::optional<double> z = under(p);
    return z && std::fabs(*z - p.z) <= 1.5 ? z : std::nullopt;
  }

 private:
  Height height_;
};

Trajectory on(const std::string& yaml, const Ground& ground) {
  return readTrajectory(parseYaml("{" + yaml + "}", "trip.yaml"), "trip", 0.1).onGround(ground);
}

double slope(double x, double y) {
  return 0.1 * x - 0.05 * y + 3;
}

// Whichever way it heads, the vehicle's z axis is the plane's normal, its heading over ground is that of the way, and
// its origin lies on the plane. Waypoints at the ground need no key for that.
TEST(GroundProfile, StandsSquareOnAPlane) {
  const Hills plane(slope);
  const Vec3d normal = normalized(Vec3d{-0.1, 0.05, 1});
  for (const Vec2d& to : {Vec2d{40, 0}, Vec2d{0, 40}, Vec2d{-30, 30}, Vec2d{-40, -1}}) {
    for (const bool atGround : {true, false}) {
      const std::string line = fmt::format("waypoints: [[0, 0, {}], [{}, {}, {}]], speed: 5", atGround ? 3 : 9, to.x,
                                           to.y, atGround ? slope(to.x, to.y) : 0);
      const Pose given = readTrajectory(parseYaml("{" + line + ", ground: none}", "t"), "t", 0.1).pose(20, 0.03);
      const Pose pose = on(line + (atGround ? "" : ", ground: drop"), plane).pose(20, 0.03);
      const Mat3 axes = toMatrix(pose.rotation);
      EXPECT_LT(length(axes.z - normal), 1e-9) << line;
      const Vec3d ahead = toMatrix(given.rotation).x;
      EXPECT_NEAR(axes.x.x * ahead.y - axes.x.y * ahead.x, 0, 1e-9) << line;
      EXPECT_GT(axes.x.x * ahead.x + axes.x.y * ahead.y, 0) << line;
      EXPECT_NEAR(pose.translation.z, slope(pose.translation.x, pose.translation.y), 1e-9) << line;
    }
  }
}

// Waypoints away from the ground, and `ground: none`, keep their heights, and the vehicle stays upright.
TEST(GroundProfile, FlyingVehiclesKeepTheirHeights) {
  const Hills plane(slope);
  for (const char* line :
       {"waypoints: [[0, 0, 4.8], [40, 0, 8.8]], speed: 5", "waypoints: [[0, 0, 3], [40, 0, 30]], speed: 5",
        "waypoints: [[0, 0, 3], [40, 0, 7]], speed: 5, ground: none"}) {
    const Trajectory given = readTrajectory(parseYaml(std::string("{") + line + "}", "t"), "t", 0.1);
    const Trajectory drive = given.ground() == nullptr ? given : on(line, plane);
    EXPECT_EQ(drive.ground(), nullptr) << line;
    EXPECT_EQ(drive.pose(20, 0.03).translation.z, given.pose(20, 0.03).translation.z) << line;
  }
}

TEST(GroundProfile, KeepsItsHeightAndUprightWithoutWheels) {
  const Hills plane(slope);
  const Pose pose =
      on("waypoints: [[0, 0, 0], [40, 0, 0]], speed: 5, ground: {height: 1.8, wheels: none}", plane).pose(10, 0);
  EXPECT_NEAR(pose.translation.z, slope(5, 0) + 1.8, 1e-9);
  EXPECT_EQ(toMatrix(pose.rotation).z, (Vec3d{0, 0, 1}));
}

double step(double x, double) {
  return x < 20 ? 0 : 0.12;
}

// Up a kerb: on both sides of it level, and in between as steep as the wheels make it.
TEST(GroundProfile, ClimbsAKerb) {
  const Trajectory drive = on("waypoints: [[0, 0, 0], [40, 0, 0]], speed: 1, every_s: 1, ground: drop", Hills(step));
  const auto pitchAt = [&](double x) {
    const Vec3d ahead = toMatrix(drive.pose(0, x).rotation).x;
    return std::atan2(ahead.z, ahead.x);
  };
  EXPECT_NEAR(pitchAt(17), 0, 1e-9);
  EXPECT_NEAR(pitchAt(20), std::atan(0.12 / 2.7), 1e-6);
  EXPECT_NEAR(pitchAt(23), 0, 1e-9);
  EXPECT_NEAR(drive.pose(0, 17).translation.z, 0, 1e-9);
  EXPECT_NEAR(drive.pose(0, 20).translation.z, 0.06, 1e-6);
  EXPECT_NEAR(drive.pose(0, 23).translation.z, 0.12, 1e-9);
  // Smooth: no more than a sixth of the kerb in 5 cm of way.
  for (double x = 15; x < 25; x += 0.05) {
    EXPECT_LT(std::fabs(drive.pose(0, x + 0.05).translation.z - drive.pose(0, x).translation.z), 0.02) << x;
  }
}

double gap(double x, double) {
  return x > 10 && x < 15 ? NAN : 2;
}

TEST(GroundProfile, KeepsItsHeightOverGapsAndSaysHowMuchOfTheWayTheyAre) {
  const Trajectory drive = on("waypoints: [[0, 0, 0], [50, 0, 0]], speed: 10, ground: {wheels: none}", Hills(gap));
  for (double t = 0; t < 5; t += 0.1) EXPECT_NEAR(drive.pose(0, t).translation.z, 2, 1e-9) << t;
  EXPECT_NEAR(drive.bareShare(), 0.1, 0.005);
  const auto nothing = [](double, double) { return double{NAN}; };
  EXPECT_THAT(
      messageOf([&] { on("waypoints: [[7, 0, 0], [50, 0, 0]], speed: 10, ground: drop", Hills(nothing)); }),
      testing::AllOf(HasSubstr("trip.yaml:1"), HasSubstr("no part of the path"), HasSubstr("[7.00, 0.00, 0.00]")));
  EXPECT_THAT(messageOf([&] { on("poses: [{position: [7, 0, 0]}], ground: drop", Hills(nothing)); }),
              HasSubstr("has no ground above or below it"));
}

// A tripod that leans keeps its lean, on top of the ground's.
TEST(GroundProfile, PosesKeepTheirOwnPitchAndRoll) {
  const Hills plane(slope);
  const Trajectory upright = on("poses: [{position: [4, 2, 50], yaw_deg: 30}], ground: {height: 1.5}", plane);
  const Trajectory leans =
      on("poses: [{position: [4, 2, 50], yaw_deg: 30, pitch_deg: 7}], ground: {height: 1.5}", plane);
  EXPECT_NEAR(upright.pose(0, 0).translation.z, slope(4, 2) + 1.5, 1e-9);
  const Quat between = (inverse(upright.pose(0, 0)) * leans.pose(0, 0)).rotation;
  const Quat expected = fromYawPitchRoll(0, radians(7), 0);
  EXPECT_NEAR(between.w, expected.w, 1e-9);
  EXPECT_NEAR(between.y, expected.y, 1e-9);
}

// A road at 0 below a bridge at 6, whose deck has a joint of 0.2 m in the right lane and a hole of 3 m.
class Bridge : public Ground {
 public:
  std::optional<double> under(const Vec3d& p) const override { return deck(p) && p.z > 5.5 ? 6.0 : 0.0; }
  std::optional<double> near(const Vec3d& p) const override {
    if (deck(p) && std::fabs(p.z - 6) <= 1.5) return 6.0;
    return std::fabs(p.z) <= 1.5 ? std::optional(0.0) : std::nullopt;
  }

 private:
  static bool deck(const Vec3d& p) {
    const bool joint = p.y < 0 && p.x > 10 && p.x < 10.2;
    return p.x < 40 && !joint && !(p.x > 20 && p.x < 23);
  }
};

TEST(GroundProfile, StaysOnABridgeOverJointsAndLeavesItWhereItEnds) {
  const Bridge bridge;
  const Trajectory above = on("waypoints: [[0, 0, 7], [60, 0, 7]], speed: 10, ground: drop", bridge);
  for (double x = 0; x < 38; x += 0.25) EXPECT_NEAR(above.pose(0, x / 10).translation.z, 6, 1e-9) << x;
  EXPECT_NEAR(above.pose(0, 5.5).translation.z, 0, 1e-9) << "10 m behind its end it is on the road";
  const Trajectory below = on("waypoints: [[0, 0, 0], [60, 0, 0]], speed: 10, ground: drop", bridge);
  for (double x = 0; x < 60; x += 0.25) EXPECT_NEAR(below.pose(0, x / 10).translation.z, 0, 1e-9) << x;
}

double waves(double x, double) {
  return std::sin(x / 3);
}

// Whatever the speed: a vehicle that waits for long and then goes is where the ground is.
TEST(GroundProfile, OfARecordingThatWaitsIsAsExactAsOfAPath) {
  TemporaryFolder folder;
  std::string table = "time,x,y,z\n";
  for (int i = 0; i <= 100; ++i) table += fmt::format("{},0,0,0\n", i);
  for (int i = 1; i <= 30; ++i) table += fmt::format("{},{},0,0\n", 100 + 0.1 * i, i);
  folder.write("p.csv", table);
  const Trajectory drive =
      readTrajectory(
          parseYaml("{recorded: {file: p.csv}, ground: {wheels: none}}", (folder.path() / "t.yaml").string()), "t", 0.1)
          .onGround(Hills(waves));
  for (double t = 99; t < 103; t += 0.013) {
    const Vec3d at = drive.pose(0, t).translation;
    EXPECT_NEAR(at.z, waves(at.x, 0), 0.01) << t;
  }
}

// A sensor that takes ten seconds for a turn is on the ground until its end.
TEST(GroundProfile, ReachesToTheEndOfTheLongestTurn) {
  const Hills plane(slope);
  const Value value = parseYaml("{waypoints: [[0, 0, 0], [90, 0, 0]], speed: 5, frames: 1, ground: drop}", "t.yaml");
  const Trajectory drive = readTrajectory(value, "t", 10).onGround(plane);
  EXPECT_NEAR(drive.pose(0, 9.9).translation.z, slope(49.5, 0), 1e-9);
}

TEST(GroundProfile, WaysAreCheckedAsTheyAreDriven) {
  const auto read = [](const std::string& yaml) { readTrajectory(parseYaml("{" + yaml + "}", "t.yaml"), "t", 0.1); };
  EXPECT_THAT(messageOf([&] { read("waypoints: [[0, 0, 0], [1, 0, 8], [0, 0, 16]], speed: 5, ground: drop"); }),
              HasSubstr("goes straight back"));
  read("waypoints: [[0, 0, 0], [0.5, 0, 8], [9, 0, 0]], speed: 5, ground: drop");
  EXPECT_THAT(messageOf([&] { read("waypoints: [[0, 0, 0], [0.5, 0, 8], [9, 0, 0]], speed: 5"); }),
              HasSubstr("steeper"));
  // What is beyond `frames` need not be there.
  on("poses: [{position: [7, 0, 0]}, {position: [12, 0, 0]}], frames: 1, ground: drop", Hills(gap));
}

}  // namespace
}  // namespace scanmill
