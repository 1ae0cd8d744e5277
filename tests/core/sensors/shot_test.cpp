#include "sensors/shot.h"

#include <fmt/format.h>

#include "sensors/sensor.h"
#include "sensors/trajectory.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::shared_ptr<const BeamTable> beams(int columns) {
  return makeBeams(parseYaml(
      fmt::format("{{columns: {}, rate_hz: 10, range_m: [1, 100], elevation_deg: [1, 0]}}", columns), "sensor.yaml"));
}

Trajectory drive() {
  return readTrajectory(parseYaml("{waypoints: [[0, 0, 0], [200, 0, 0]], speed: 20}", "trip.yaml"), "trip", 0.1);
}

Motion motionOf(const std::string& text) {
  const Value value = parseYaml(text, "motion.yaml");
  return readMotion(&value);
}

std::string refusedShot(const std::string& text) {
  return messageOf([&] { motionOf(text); });
}

TEST(Motion, ReadsEveryForm) {
  EXPECT_EQ(readMotion(nullptr).kind, MotionKind::None);
  EXPECT_EQ(motionOf("none").kind, MotionKind::None);
  EXPECT_EQ(motionOf("per_column").kind, MotionKind::PerColumn);
  EXPECT_EQ(motionOf("steps: 360").kind, MotionKind::Steps);
  EXPECT_EQ(motionOf("steps: 360").steps, 360u);
  EXPECT_FALSE(motionOf("{steps: 360}").deskew);
  EXPECT_TRUE(motionOf("{steps: 360, deskew: true}").deskew);
  EXPECT_EQ(motionOf("{steps: per_column, deskew: true}").kind, MotionKind::PerColumn);
}

TEST(Motion, MalformedOnesAreRefusedWithTheirPlace) {
  for (const char* text : {"per_colum", "360", "[1]", "{steps: 0}", "{steps: 65537}", "{steps: 1.5}", "{steps: -1}",
                           "{deskew: true}", "{steps: 3, deskew: maybe}", "{steps: 3, skew: true}"}) {
    EXPECT_THAT(refusedShot(text), HasSubstr("motion.yaml:1:")) << text;
  }
}

TEST(Shot, EveryColumnBelongsToOneStepAndEveryStepHasColumns) {
  for (const int columns : {1000, 1024}) {
    for (const int steps : {1, 7, 360, columns}) {
      const Shot shot = makeShot(beams(columns), drive(), 3, {}, motionOf(fmt::format("steps: {}", steps)));
      ASSERT_EQ(shot.worldFromSensor.size(), static_cast<std::size_t>(steps));
      std::vector<int> count(steps, 0);
      std::size_t before = 0;
      for (int column = 0; column < columns; ++column) {
        const std::size_t step = shot.stepOf(static_cast<std::uint32_t>(column));
        ASSERT_LT(step, count.size());
        if (steps == columns) {
          ASSERT_EQ(step, static_cast<std::size_t>(column));
        }
        ASSERT_GE(step, before);
        if (count[step]++ == 0) {
          // The pose of a step is the vehicle's when its first column fires.
          const double time = 0.3 + 0.1 * column / columns;
          EXPECT_LT(length(shot.worldFromSensor[step].translation - Vec3d{20 * time, 0, 0}), 1e-9);
        }
        before = step;
      }
      for (const int n : count) {
        EXPECT_GE(n, columns / steps);
        EXPECT_LE(n, (columns + steps - 1) / steps);
      }
    }
  }
}

TEST(Shot, NoMotionTakesThePoseAtTheStartOfTheTurn) {
  const Pose mount{fromYawPitchRoll(kPi / 2, 0, 0), {1, 0, 2}};
  const auto table = beams(100);
  const Shot shot = makeShot(table, drive(), 7, mount, {});
  ASSERT_EQ(shot.worldFromSensor.size(), 1u);
  EXPECT_LT(length(shot.worldFromSensor[0].translation - Vec3d{15, 0, 2}), 1e-9);
  EXPECT_LT(length(toMatrix(shot.worldFromSensor[0].rotation).x - Vec3d{0, 1, 0}), 1e-12);
  EXPECT_DOUBLE_EQ(shot.time, 0.7);
  EXPECT_EQ(shot.frame, 7u);
  EXPECT_EQ(shot.beams, table);
}

TEST(Shot, AStandingVehicleNeedsOnePose) {
  const Trajectory still = readTrajectory(parseYaml("{poses: [{position: [1, 2, 3]}]}", "trip.yaml"), "trip", 0.1);
  const Shot shot = makeShot(beams(100), still, 0, {}, motionOf("per_column"));
  EXPECT_EQ(shot.worldFromSensor.size(), 1u);
  EXPECT_EQ(shot.stepOf(99), 0u);
}

TEST(Shot, MoreStepsThanColumnsAreRefused) {
  expectInputError([] { makeShot(beams(100), drive(), 0, {}, motionOf("{steps: 101}")); },
                   {"motion.yaml:1:", "101 steps"});
}

}  // namespace
}  // namespace scanmill
