// The vehicle drives while the sensor turns.

#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class MotionTest : public Yard {
 protected:
  // Distance of each wall point to the yard's nearest inner face, when the point is seen from where the turn started.
  std::vector<double> wallErrors(const Manifest& m, const std::string& name = "out") const {
    const std::uint16_t wall = m.ontology.require("wall", {}).id;
    std::vector<double> errors;
    const std::vector<Scan> all = scans(".pcd", name);
    for (std::size_t s = 0; s < all.size(); ++s) {
      const Pose& start = m.samples[s].scans[0].worldFromSensor.front();
      for (std::size_t i = 0; i < all[s].size(); ++i) {
        if (all[s][kLabel][i] != wall) continue;
        const Vec3d p = start * Vec3d(all[s].position[i]);
        errors.push_back(std::min(std::abs(std::abs(p.x) - 30), std::abs(std::abs(p.y) - 20)));
      }
    }
    EXPECT_GT(errors.size(), 100u);
    return errors;
  }

  static double worst(const std::vector<double>& errors) { return *std::max_element(errors.begin(), errors.end()); }
};

// 20 m/s for 0.1 s: 2 m, all but the last column's step.
constexpr double kSkew = 2;

TEST_F(MotionTest, WithoutMotionATurnHasOnePose) {
  const Manifest m = sound({"motion=none"});
  EXPECT_LT(worst(wallErrors(m)), 1e-4);
  EXPECT_EQ(m.samples[0].scans[0].worldFromSensor.size(), 1u);
  EXPECT_FALSE(m.deskewed);
}

TEST_F(MotionTest, PerColumnSkewsByTheWayDriven) {
  const Manifest m = sound({"motion=per_column"});
  const double skew = worst(wallErrors(m));
  EXPECT_GT(skew, 0.8 * kSkew);
  EXPECT_LT(skew, kSkew);
  const auto& poses = m.samples[0].scans[0].worldFromSensor;
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_NEAR(poses[1].translation.x - poses[0].translation.x, kSkew * 63 / 64, 1e-9);
}

TEST_F(MotionTest, DeskewedWallsAreFlat) {
  for (const char* motion : {"motion={steps: per_column, deskew: true}", "motion={steps: 7, deskew: true}"}) {
    const Manifest m = sound({motion}, motion);
    EXPECT_TRUE(m.deskewed);
    EXPECT_LT(worst(wallErrors(m, motion)), 1e-4) << motion;
  }
}

// A number of steps that does not divide the columns keeps every ray.
TEST_F(MotionTest, StepsKeepEveryRay) {
  const auto beams = [](const std::vector<Scan>& all) {
    std::size_t count = 0;
    for (const Scan& s : all) count += s.size();
    return count;
  };
  sound({}, "none");
  for (const int steps : {1, 7, 63, 64}) {
    const std::string name = fmt::format("s{}", steps);
    const Manifest m = sound({fmt::format("motion={{steps: {}}}", steps)}, name);
    EXPECT_EQ(beams(scans(".pcd", name)), beams(scans(".pcd", "none"))) << steps;  // the yard is closed: no misses
  }
  sound({"motion=per_column"}, "per_column");
  EXPECT_TRUE(members("per_column") == members("s64"));
  EXPECT_TRUE(members("none") == members("s1"));
}

// From one point to another on the yard's floor, around the cars: as many frames as are asked for, at its speed.
TEST_F(MotionTest, DrivesFromOnePointToAnother) {
  const auto trip = [](int frames) {
    return fmt::format("trajectories=[{{name: trip, on: ground, from: [-22, 5], to: [24, 5], speed: 20, frames: {}}}]",
                       frames);
  };
  const Manifest m = sound({trip(12)});
  ASSERT_EQ(m.samples.size(), 12u);
  std::vector<Vec3d> places;
  for (const SampleRecord& sample : m.samples) {
    places.push_back(sample.scans.at(0).worldFromSensor.front().translation);
    const Vec3d& p = places.back();
    EXPECT_NEAR(p.z, 1.8, 1e-6);
    EXPECT_FALSE(std::fabs(p.x - 8) < 2.8 && std::fabs(p.y - 5) < 1.8) << "through the car";
  }
  EXPECT_LT(length(places.front() - Vec3d{-22, 5, 1.8}), 1.6);
  for (std::size_t i = 1; i < places.size(); ++i) EXPECT_NEAR(length(places[i] - places[i - 1]), 2, 0.1) << i;
  EXPECT_THAT(messageOf([&] { run({trip(40)}, "long"); }), AllOf(HasSubstr("m long, but"), HasSubstr("frames less")));
  EXPECT_THAT(messageOf([&] { run({"trajectories=[{on: ground, to: [1, 2], speed: 2, frames: 2}]"}, "no"); }),
              HasSubstr("'from' is missing"));
  EXPECT_THAT(
      messageOf([&] { run({"trajectories=[{waypoints: [[0, 0, 0], [9, 0, 0]], to: [1, 2], speed: 2}]"}, "no"); }),
      HasSubstr("to is for drives that have `on`"));
}

}  // namespace
}  // namespace scanmill
