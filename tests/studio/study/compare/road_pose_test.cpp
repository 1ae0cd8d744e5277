#include "study/compare/road_pose.h"

#include <map>

#include "study/compare/compare.h"

namespace scanmill {
namespace {

constexpr std::uint16_t kRoadLabel = 1, kWalkLabel = 2, kCarLabel = 3;

const Ontology kStreetClasses{"street",
                              "",
                              {{0, "unlabeled", {}, false, {}, {}},
                               {kRoadLabel, "drivable", {}, false, {"road"}, {}},
                               {kWalkLabel, "sidewalk", {}, false, {}, {}},
                               {kCarLabel, "car", {}, true, {}, {}}}};

// A plane street at the height 0, with sidewalks right of y = -3.25 m and left of y = 4.5 m, and a car 6 m ahead.
Scan streetFrom(const Pose& worldFromSensor) {
  Scan scan;
  const Mat3 worldFromPoint = toMatrix(worldFromSensor.rotation);
  const auto add = [&](const Vec3d& point, std::uint16_t label) {
    const Vec3d p = point - worldFromSensor.translation;
    const Vec3d seen{dot(worldFromPoint.x, p), dot(worldFromPoint.y, p), dot(worldFromPoint.z, p)};
    scan.position.push_back(static_cast<Vec3f>(seen));
    scan[kLabel].push_back(label);
  };
  for (double x = -15; x < 15; x += 0.2) {
    for (double y = -14.95; y < 15; y += 0.1) add({x, y, 0}, y < -3.25 || y > 4.5 ? kWalkLabel : kRoadLabel);
  }
  for (double y = -0.8; y < 0.8; y += 0.05) {
    for (double z = 0.3; z < 1.4; z += 0.05) add({6, y, z}, kCarLabel);
  }
  return scan;
}

Pose mountAt(double height, double yaw, double pitch, double roll) {
  return {fromYawPitchRoll(radians(yaw), radians(pitch), radians(roll)), {0, 0, height}};
}

TEST(RoadPose, IsThatOfTheMountOverAPlaneOfAnySlope) {
  for (const double pitch : {-25.0, -0.7, 2.0, 14.0}) {
    for (const double roll : {-17.0, 0.0, 1.0, 30.0}) {
      const RoadPose pose = roadPoseOf(streetFrom(mountAt(1.9, 130, pitch, roll)), &kStreetClasses);
      EXPECT_NEAR(pose[kPitch], pitch, 1e-3);
      EXPECT_NEAR(pose[kRoll], roll, 1e-3);
      EXPECT_NEAR(pose[kLaneSlope], -roll, 1e-3);
      EXPECT_NEAR(pose[kHeight], 1.9, 1e-4);
    }
  }
  const RoadPose unlabelled = roadPoseOf(streetFrom(mountAt(1.7, 0, 3, -2)), nullptr);
  EXPECT_NEAR(unlabelled[kPitch], 3, 0.05);
  EXPECT_NEAR(unlabelled[kRoll], -2, 0.05);
  EXPECT_NEAR(unlabelled[kHeight], 1.7, 0.01);
  for (const double value : roadPoseOf(Scan(), nullptr)) EXPECT_TRUE(std::isnan(value));
}

// The points of some layouts have the y axis ahead.
TEST(RoadPose, KnowsTheRoadsEdgesWhateverTheFrame) {
  for (const double heading : {0.0, 90.0}) {
    const RoadPose pose = roadPoseOf(streetFrom(mountAt(1.7, -heading, 0, 0)), &kStreetClasses, radians(heading));
    EXPECT_EQ(pose[kLeftEdge], 4.5);
    EXPECT_EQ(pose[kRightEdge], 3.25);
  }
}

TEST(RoadPose, OfSetsThatDifferInTheMountAloneLeadsToTheMount) {
  const auto setFrom = [](const Pose& mount) { return measureScans("set", {streetFrom(mount)}, kStreetClasses); };
  const Value present = parseYaml("{position: [0.5, 0, 1.8], yaw_deg: 4, roll_deg: -0.5}", "mount");
  const SetComparison found = compareSets(setFrom(mountAt(2, 0, 2, 1)), setFrom(mountAt(1.8, 0, 0, 0)));
  EXPECT_EQ(differenceText(kPitch, found.real.roadPose, found.simulated.roadPose), "2 deg less down");
  Value mount = present;
  EXPECT_EQ(changeMount(found, "sensors.1.mount", true, mount).at(0).key, "sensors.1.mount.position.2");
  EXPECT_EQ(flowText(mount), "{position: [0.5, 0, 2], yaw_deg: 4, roll_deg: 0.5, pitch_deg: 2}");
  EXPECT_EQ(changeMount(found, "sensors.1.mount", false, mount = present).size(), 2u);  // no roll without wheels

  const SetComparison same = compareSets(setFrom(mountAt(2, 0, 2, 1)), setFrom(mountAt(2, 0, 2, 1)));
  EXPECT_THAT(changeMount(same, "sensors.1.mount", true, mount), testing::IsEmpty());
}

// The sequences' medians are 1, 2 and 3 of the real set, and 0.9, 1 and 1.1 of the simulated set.
TEST(RoadPose, IsAdvisedAsADistributionWhereRealSequencesDifferMore) {
  const auto spreads = [](double mean, double step) {
    PosesBySequence poses;
    for (int i = -1; i <= 1; ++i) {
      for (const double beside : {-0.01, 0.0, 0.01}) {
        RoadPose pose;
        pose.fill(std::nan(""));
        pose[kPitch] = mean + i * step + beside;
        poses[std::to_string(i)].push_back(pose);
      }
    }
    return spreadsOf(poses);
  };
  SetComparison unlike;
  unlike.real.roadPose = spreads(2, 1);
  unlike.simulated.roadPose = spreads(1, 0.1);
  const FigureSpread& pitch = unlike.real.roadPose[kPitch];
  EXPECT_NEAR(pitch.overSequences, 1, 1e-9);
  EXPECT_TRUE(pitch.median == 2 && pitch.low < 1.02 && pitch.high > 2.98);
  EXPECT_TRUE(std::isnan(unlike.real.roadPose[kHeight].median));
  for (const auto& [present, advised] :
       std::map<std::string, std::string>{{"{}", "{position: [0, 0, 0], pitch_deg: {normal: [1, 0.99]}}"},
                                          {"{pitch_deg: {uniform: [0, 1]}}", "{pitch_deg: {uniform: [0, 1]}}"}}) {
    Value mount = parseYaml(present, "mount");
    changeMount(unlike, "sensors.0.mount", true, mount);
    EXPECT_EQ(flowText(mount), advised);
  }
}

}  // namespace
}  // namespace scanmill
