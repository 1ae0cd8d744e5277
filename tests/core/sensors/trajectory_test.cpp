#include "sensors/trajectory.h"

#include "base/path.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

Trajectory trajectoryOf(const std::string& text) {
  return readTrajectory(parseYaml(text, "trip.yaml"), "trip", 0.1);
}

std::string trajectoryRefusal(const std::string& text) {
  return messageOf([&] { trajectoryOf(text); });
}

Vec3d headingAt(const Pose& pose) {
  return toMatrix(pose.rotation).x;
}

const std::vector<Vec3d> kCorners = {{0, 0, 0},    {50, 0, 0},   {60, 10, 1},   {60, 90, 2},  {55, 95, 2.5},
                                     {-40, 95, 0}, {-45, 90, 0}, {-45, 20, -3}, {-30, 5, -1}, {0, 0, 0}};

TEST(Path, PassesEveryWaypoint) {
  const Path path(kCorners);
  double before = -1;
  for (std::size_t i = 0; i < kCorners.size(); ++i) {
    const double distance = path.distanceOfPoint(i);
    EXPECT_GT(distance, before);
    EXPECT_LT(length(path.pose(distance).translation - kCorners[i]), 1e-9) << i;
    before = distance;
  }
  EXPECT_DOUBLE_EQ(before, path.length());
}

TEST(PathOfLines, KeepsToTheLinesButForItsCorners) {
  constexpr double kRounding = 2;
  const Path path = Path::lines(kCorners, kRounding);
  const auto offLines = [&](const Vec3d& p) {
    double nearest = INFINITY;
    for (std::size_t i = 0; i + 1 < kCorners.size(); ++i) {
      const Vec3d chord = kCorners[i + 1] - kCorners[i];
      const double on = std::clamp(dot(p - kCorners[i], chord) / dot(chord, chord), 0.0, 1.0);
      nearest = std::min(nearest, length(p - kCorners[i] - chord * on));
    }
    return nearest;
  };
  Vec3d heading = headingAt(path.pose(0));
  for (double at = 0; at <= path.length(); at += 0.01) {
    const Pose pose = path.pose(at);
    double corner = INFINITY;
    for (const Vec3d& c : kCorners) corner = std::min(corner, length(c - pose.translation));
    EXPECT_LT(offLines(pose.translation), corner > kRounding ? 1e-9 : 0.36 * kRounding) << at;
    EXPECT_GT(dot(heading, headingAt(pose)), std::cos(0.03)) << at;  // it never jumps
    heading = headingAt(pose);
  }
  EXPECT_EQ(path.pose(0).translation, kCorners.front());
  EXPECT_LT(length(path.pose(path.length()).translation - kCorners.back()), 1e-9);
}

// The parabola of a right angle is r * sqrt(2) / 4 away from the corner, where it is passed.
TEST(PathOfLines, RoundsARightAngleByAParabola) {
  const Path path = Path::lines({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}}, 2);
  const Vec3d nearest = path.pose(path.distanceOfPoint(1)).translation;
  EXPECT_NEAR(length(nearest - Vec3d{10, 0, 0}), 2 * std::sqrt(2) / 4, 1e-9);
  EXPECT_NEAR(path.distanceOfPoint(2), path.length(), 1e-12);
  // Half the way to the next point at most.
  const Path narrow = Path::lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 100);
  EXPECT_NEAR(length(narrow.pose(narrow.distanceOfPoint(1)).translation - Vec3d{1, 0, 0}), 0.5 * std::sqrt(2) / 4,
              1e-9);
}

TEST(PathOfLines, StraightOnIsTheLineItself) {
  const Path path = Path::lines({{0, 0, 0}, {4, 0, 0}, {9, 0, 0}}, 0.5);
  EXPECT_NEAR(path.length(), 9, 1e-12);
  EXPECT_NEAR(path.pose(4).translation.x, 4, 1e-12);
}

// On a helix, since it tells of the heading over ground. To the left is positive; at the ends it tells of what there
// is.
TEST(Path, CurvatureOfAHelixFollowsItsRadiusAndRise) {
  constexpr double kRadius = 25;
  const double expected = 1 / kRadius / std::hypot(1, 0.2);
  std::vector<Vec3d> points;
  for (int i = 0; i <= 200; ++i)
    points.push_back({kRadius * std::cos(0.02 * i), kRadius * std::sin(0.02 * i), 0.1 * i});
  const Path left(points);
  std::reverse(points.begin(), points.end());
  const Path right(points);
  for (const double at : {5.0, 50.3, 90.0}) {
    EXPECT_NEAR(left.curvature(at, 3), expected, 1e-4) << at;
    EXPECT_NEAR(right.curvature(at, 3), -expected, 1e-4) << at;
  }
  for (const double end : {0.0, left.length()}) EXPECT_NEAR(left.curvature(end, 3), expected, 4e-3) << end;
  EXPECT_NEAR(Path({{0, 0, 0}, {9, 3, 1}, {18, 6, 1}}).curvature(9, 2), 0, 1e-9);
}

TEST(Path, StraightLineIsItsOwnLength) {
  const Path path({{1, 2, 3}, {1, 5, 3}, {1, 6, 3}, {1, 106, 3}});
  EXPECT_NEAR(path.length(), 104, 1e-9);
  for (double s = 0; s <= 104; s += 0.37) {
    const Pose pose = path.pose(s);
    EXPECT_LT(length(pose.translation - Vec3d{1, 2 + s, 3}), 1e-9);
    EXPECT_LT(length(headingAt(pose) - Vec3d{0, 1, 0}), 1e-9);
  }
}

TEST(Path, SpeedIsConstantAndHeadingIsContinuousAndAlongTheMotion) {
  const double turn = radians(174);
  const std::vector<Vec3d> hairpin{{0, 0, 0}, {80, 0, 0}, {80 + 30 * std::cos(turn), 30 * std::sin(turn), 0}};
  for (const std::vector<Vec3d>& points : {kCorners, hairpin}) {
    const Path path(points);
    const double step = 1e-3;
    const double straight = points == kCorners ? 0.999999 : 0.999;
    double travelled = 0;
    Pose before = path.pose(0);
    for (double s = step; s < path.length(); s += step) {
      const Pose pose = path.pose(s);
      const Vec3d moved = pose.translation - before.translation;
      ASSERT_NEAR(length(moved) / step, 1, 0.01) << s;
      ASSERT_GT(dot(normalized(moved), headingAt(pose)), straight) << s;
      ASSERT_GT(dot(headingAt(before), headingAt(pose)), straight) << s;
      ASSERT_NEAR(toMatrix(pose.rotation).y.z, 0, 1e-12);  // no roll
      travelled += length(moved);
      before = pose;
    }
    EXPECT_NEAR(travelled, path.length(), 2e-3);
  }
}

TEST(Path, MovedFarAwayItKeepsItsShape) {
  std::vector<Vec3d> moved = kCorners;
  for (Vec3d& p : moved) p += Vec3d{1e7, -1e7, 100};
  const Path here(kCorners);
  const Path there(moved);
  EXPECT_NEAR(here.length(), there.length(), 1e-5);
  for (double s = 0; s < here.length(); s += 3.3) {
    EXPECT_LT(length(here.pose(s).translation + Vec3d{1e7, -1e7, 100} - there.pose(s).translation), 1e-5);
  }
}

TEST(Path, UphillPitchesUp) {
  const Pose pose = Path({{0, 0, 0}, {10, 0, 1}}).pose(5);
  EXPECT_GT(headingAt(pose).z, 0);
  EXPECT_NEAR(headingAt(pose).z / headingAt(pose).x, 0.1, 1e-12);
}

TEST(Trajectory, ConstantVelocityIsLinearInTime) {
  const Trajectory trip = trajectoryOf("{waypoints: [[0, 0, 1], [30, 40, 1]], speed: 5, every_s: 0.5}");
  EXPECT_FALSE(trip.still());
  EXPECT_EQ(trip.frames(), 21u);  // 10 s, the frame at the end included
  for (std::uint32_t frame = 0; frame < 20; ++frame) {
    EXPECT_NEAR(trip.frameTime(frame), 0.5 * frame, 1e-12);
    for (const double dt : {0.0, 0.03, 0.1}) {
      const double time = 0.5 * frame + dt;
      const Pose pose = trip.pose(frame, dt);
      EXPECT_LT(length(pose.translation - Vec3d{3 * time, 4 * time, 1}), 1e-9);
      EXPECT_LT(length(headingAt(pose) - Vec3d{0.6, 0.8, 0}), 1e-12);
    }
  }
}

TEST(Trajectory, StopsAtTheEndOfThePath) {
  const Trajectory trip = trajectoryOf("{waypoints: [[0, 0, 0], [10, 0, 0]], speed: 10, frames: 500}");
  EXPECT_EQ(trip.frames(), 11u);
  EXPECT_EQ(trip.pose(10, 5).translation, (Vec3d{10, 0, 0}));
  EXPECT_THROW(trip.pose(11, 0), Error);
}

TEST(Trajectory, FramesComeByDistanceByTimeOrByTheTurn) {
  const std::string way = "{waypoints: [[0, 0, 0], [100, 0, 0]], speed: 20";
  EXPECT_EQ(trajectoryOf(way + ", every_m: 2}").frames(), 51u);
  EXPECT_NEAR(trajectoryOf(way + ", every_m: 2}").frameTime(10), 1, 1e-12);
  EXPECT_EQ(trajectoryOf(way + ", every_s: 1}").frames(), 6u);
  EXPECT_EQ(trajectoryOf(way + "}").frames(), 51u);  // the sensor's turn, 0.1 s
  EXPECT_EQ(trajectoryOf(way + ", frames: 3}").frames(), 3u);
  EXPECT_EQ(trajectoryOf("{waypoints: [[0, 0, 0], [1, 0, 0]], speed: 1, every_s: 100}").frames(), 1u);
}

TEST(Trajectory, ListedPosesStandStill) {
  const Trajectory trip =
      trajectoryOf("{poses: [{position: [1, 2, 3]}, {position: [4, 5, 6], yaw_deg: 90}, {}], every_s: 2, name: stops}");
  EXPECT_TRUE(trip.still());
  EXPECT_EQ(trip.name(), "stops");
  ASSERT_EQ(trip.frames(), 3u);
  EXPECT_EQ(trip.pose(1, 0), trip.pose(1, 1.5));
  EXPECT_EQ(trip.pose(1, 0).translation, (Vec3d{4, 5, 6}));
  EXPECT_LT(length(headingAt(trip.pose(1, 0)) - Vec3d{0, 1, 0}), 1e-12);
  EXPECT_DOUBLE_EQ(trip.frameTime(2), 4);
  EXPECT_EQ(trajectoryOf("{poses: [{}, {}, {}], frames: 2}").frames(), 2u);
  EXPECT_DOUBLE_EQ(trajectoryOf("{poses: [{}, {}]}").frameTime(1), 0.1);
}

TEST(Trajectory, AnEmptyKeyCountsAsNone) {
  for (const std::string kind : {"waypoints: [[0, 0, 0], [100, 0, 0]]\nspeed: 9\nevery_m: 1\n", "poses: [{}, {}]\n"}) {
    for (const std::string key :
         {"name", "poses",  "waypoints", "along",        "on",    "from", "to",     "recorded", "path",    "rounding",
          "keep", "drives", "speed",     "acceleration", "stops", "sway", "ground", "every_s",  "every_m", "frames"}) {
      if (kind.find(key + ":") != std::string::npos) continue;
      EXPECT_EQ(trajectoryRefusal(kind + key + ":\n"), "accepted") << kind << key;
    }
  }
}

TEST(Trajectory, MalformedOnesAreRefusedWithTheirPlace) {
  const std::string line = "waypoints: [[0, 0, 0], [100, 0, 0]]\n";
  const std::string driven = line + "speed: 9\nacceleration: 2\n";
  expectRefusals(trajectoryRefusal, {{"", "give exactly one of poses, waypoints, along, on and recorded"},
                                     {"{poses: []}", "trip.yaml:1:9: "},
                                     {"{poses: [{position: [0, 0]}]}", "trip.yaml:1:"},
                                     {"{poses: [{yaw: 3}]}", "yaw_deg"},
                                     {"{poses: [{}], speed: 3}", "speed"},
                                     {"{poses: [{position: [1e300, 0, 0]}]}", "farther than"},
                                     {line + "speed: 3\nposes: [{}]", "has poses and waypoints: give exactly one of"},
                                     {line, "speed"},
                                     {"{along: lane, speed: 3}", "here is no town"},
                                     {line + "along: lane\nspeed: 3", "has waypoints and along"},
                                     {"{along: lane, poses: [{}]}", "has poses and along: give exactly one of"},
                                     {line + "speed: 0", "trip.yaml:2:8: "},
                                     {line + "speed: -1", "trip.yaml:2:8: "},
                                     {line + "speed: 101", "trip.yaml:2:8: "},
                                     {line + "speed: 1\nevery_s: 0", "trip.yaml:3:10: "},
                                     {line + "speed: 1\nevery_s: 1\nevery_m: 1", "trip.yaml:4:10: "},
                                     {line + "speed: 1\nframes: 0", "trip.yaml:3:9: "},
                                     {line + "speed: 1\nframes: 1e9", "trip.yaml:3:9: "},
                                     {line + "speed: 1\nevery: 2", "trip.yaml:3:"},
                                     {line + "speed: 1\nframe: 2", "did you mean 'frames'"},
                                     {line + "speed: 1\nfrmaes: 2", "did you mean 'frames'"},
                                     {line + "speed: 1\nacceleraton: 2", "did you mean 'acceleration'"},
                                     {"{on: road, speed: 1, form: [0, 0]}", "did you mean 'from'"},
                                     {"{waypoint: [], speed: 1}", "did you mean 'waypoints'"},
                                     {"pose: [{}]", "did you mean 'poses'"},
                                     {"recordd: {}", "did you mean 'recorded'"},
                                     {"{poses: [{}], from: [0, 0]}", "from is for paths that are driven"},
                                     {"{along: lanes, speed: 3}", "did you mean 'lane'"},
                                     {line + "speed: 9\nstops: [{at: 9}]", "stops need the key `acceleration`"},
                                     {driven + "stops: 3", "trip.yaml:4:"},
                                     {driven + "stops: [{at: 200}]", "trip.yaml:4:"},
                                     {driven + "stops: [{at: 20}, {at: 20.5}]", "at least 1 m apart"},
                                     {driven + "sway: {yaw_deg: 3}", "yaw_deg"},
                                     {"{poses: [{}], acceleration: 3}", "acceleration"},
                                     {"{waypoints: [[0, 0, 0]], speed: 1}", "at least two"},
                                     {"{waypoints: [[0, 0, 0], [0, 0, 0]], speed: 1}", "trip.yaml:1:25: "},
                                     {"{waypoints: [[0, 0, 0], [0, 0, 9]], speed: 1}", "steeper"},
                                     {"{waypoints: [[0, 0, 0], [9, 0, 0], [1, 0, 0]], speed: 1}", "straight back"},
                                     {"{waypoints: [[0, 0, 0], [1e12, 0, 0]], speed: 1}", "farther than"}});
}

TEST(Trajectory, AcceleratesFromRestAndStops) {
  const std::string text =
      "{waypoints: [[0, 0, 0], [100, 0, 0], [200, 0, 0]], speed: 10, acceleration: 2, "
      "stops: [{at: 60, wait: 4}], ";
  const Trajectory byTime = trajectoryOf(text + "every_s: 0.5}");
  EXPECT_NEAR(byTime.pose(2, 0).translation.x, 1, 1e-6);  // 2 t^2 / 2
  EXPECT_NEAR(byTime.pose(2, 0.5).translation.x, 2.25, 1e-6);
  EXPECT_NEAR(byTime.frames(), 69, 1) << "20 s of driving, twice 5 s of speeding up and slowing down, 4 s of waiting";
  const Trajectory byWay = trajectoryOf(text + "every_m: 7}");
  EXPECT_EQ(byWay.frames(), 29u);
  for (std::uint32_t f = 0; f < byWay.frames(); ++f) EXPECT_NEAR(byWay.pose(f, 0).translation.x, 7.0 * f, 1e-6);
  EXPECT_NEAR(byWay.frameTime(8), 60.0 / 10 + 5 - std::sqrt(4.0), 1e-3) << "4 m before the stop";
}

// Its deviations are those asked for, it is smooth, and another seed sways otherwise.
TEST(Trajectory, SwaysAsMuchAsItSays) {
  const std::string text =
      "{waypoints: [[0, 0, 0], [2000, 0, 0]], speed: 10, every_s: 0.05, "
      "sway: {roll_deg: 0.5, pitch_deg: 0.3, heave_m: 0.02}}";
  const Trajectory t = readTrajectory(parseYaml(text, "trip.yaml"), "trip", 0.1, nullptr, 3);
  const Trajectory other = readTrajectory(parseYaml(text, "trip.yaml"), "trip", 0.1, nullptr, 4);
  double roll = 0, pitch = 0, heave = 0;
  double apart = 0;
  for (std::uint32_t f = 0; f < t.frames(); ++f) {
    const Pose p = t.pose(f, 0);
    const Mat3 m = toMatrix(p.rotation);
    roll += std::pow(std::atan2(m.y.z, m.z.z), 2) / t.frames();
    pitch += std::pow(std::asin(m.x.z), 2) / t.frames();
    heave += p.translation.z * p.translation.z / t.frames();
    apart = std::max(apart, std::abs(p.translation.z - other.pose(f, 0).translation.z));
    EXPECT_LT(std::abs(t.pose(f, 0.01).translation.z - p.translation.z), 0.02 * 2 * kPi * 2 * 0.01 * 5);
  }
  EXPECT_NEAR(std::sqrt(roll), radians(0.5), radians(0.05));
  EXPECT_NEAR(std::sqrt(pitch), radians(0.3), radians(0.03));
  EXPECT_NEAR(std::sqrt(heave), 0.02, 0.002);
  EXPECT_GT(apart, 0.02);
}

TEST(Trajectory, DoesNotSwayAtRest) {
  const Trajectory t = trajectoryOf(
      "{waypoints: [[0, 0, 0], [100, 0, 0]], speed: 10, acceleration: 2, every_s: 0.1, sway: {heave_m: 0.1}}");
  EXPECT_EQ(t.pose(0, 0).translation.z, 0);
}

TEST(Trajectory, HugeFrameCountsAreRefusedWithTheArithmetic) {
  const std::string message = trajectoryRefusal("{waypoints: [[0, 0, 0], [1000, 0, 0]], speed: 10, every_m: 1e-6}");
  EXPECT_THAT(message, HasSubstr("1000 m of path / 10 m/s / 1e-07 s per frame = 1e+09 frames"));
  EXPECT_THAT(message, HasSubstr("10000000"));
  EXPECT_EQ(trajectoryOf("{waypoints: [[0, 0, 0], [1000, 0, 0]], speed: 10, every_m: 1e-6, frames: 9}").frames(), 9u);
}

TEST(TrajectoryPath, LinesAreDrivenThroughTheirCorners) {
  const std::string corner = "waypoints: [[0, 0, 0], [10, 0, 0], [10, 10, 0]], speed: 1, every_m: 1";
  const Trajectory line = trajectoryOf("{path: line, rounding: 1, " + corner + "}");
  EXPECT_EQ(line.pose(8, 0).translation, (Vec3d{8, 0, 0}));
}

TEST(TrajectoryPath, RefusesKeysOfOtherWays) {
  const std::string line = "waypoints: [[0, 0, 0], [50, 0, 0]], speed: 3";
  expectRefusals(trajectoryRefusal,
                 {{"{path: curve, " + line + "}", "may not be"},
                  {"{rounding: 1, " + line + "}", "rounding is for `path: line`"},
                  {"{path: line, along: lane, speed: 3}", "path is for waypoints"},
                  {"{keep: left, " + line + "}", "keep is for drives that have `on`"},
                  {"{drives: 2, " + line + "}", "drives is for random drives"},
                  {"{path: line, poses: [{}]}", "path is for paths that are driven: the vehicle stands still"},
                  {"{ground: fall, " + line + "}", "ground must be `drop`"},
                  {"{ground: {wheels: [1, 2, 3]}, " + line + "}", "[wheelbase, track]"}});
}

TEST(RandomDrive, IsAsLongAsItsFramesAtItsSpeedAndKnownByItsNumber) {
  const std::string drive = "{name: roam, \"on\": [road], speed: 8, every_s: 0.5, frames: 11, drives: 3}";
  const Value value = parseYaml(drive, "trip.yaml");
  EXPECT_EQ(countDrives(value), 3u);
  const Trajectory second = readTrajectory(value, "t0", 0.1, nullptr, 0, 1);
  EXPECT_EQ(second.name(), "roam-1");
  EXPECT_EQ(second.frames(), 11u);
  ASSERT_NE(second.randomPath(), nullptr);
  EXPECT_GE(second.randomPath()->length, 10 * 0.5 * 8);
  EXPECT_THROW(second.pose(0, 0), Error) << "its way is not known yet";
  const Trajectory known = second.along({{0, 0, 0}, {30, 0, 0}, {60, 0, 0}});
  EXPECT_NEAR(known.pose(10, 0).translation.x, 40, 1e-9);
  EXPECT_THAT(trajectoryRefusal("{\"on\": [road], speed: 8}"), HasSubstr("the number of `frames`"));
}

}  // namespace
}  // namespace scanmill
