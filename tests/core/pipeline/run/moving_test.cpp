// Objects of the scene move while the vehicle drives.

#include <set>

#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class MovingRun : public Yard {
 protected:
  // The cars drive, one along x and one along y.
  MovingRun() {
    std::string scene = yardScene();
    scene.resize(scene.find("  - name: car"));
    for (const char* place : {"[8, 5, 0.75]", "[8, -5, 0.75]"}) {
      const bool first = std::string(place).find("-5") == std::string::npos;
      scene += fmt::format(
          "  - {{name: {}, primitive: box, size: [4, 2, 1.5], class: car, material: painted_metal, position: {}, "
          "moving: {{velocity: {}}}}}\n",
          first ? "ahead" : "aside", place, first ? "[5, 0, 0]" : "[0, -3, 0]");
    }
    scene +=
        "  - {name: parked, primitive: box, size: [4, 2, 1.5], class: car, material: painted_metal, position: "
        "[-12, 8, 0.75]}\n";
    folder_.write("scenes/yard.yaml", scene);
  }

  static const std::string kColumns;
};

const std::string MovingRun::kColumns =
    "output.columns=[intensity, label, instance, ring, column, time, velocity_x, velocity_y, velocity_z]";

constexpr ColumnKey<columnIndex("velocity_x")> kVelocityX;
constexpr ColumnKey<columnIndex("velocity_y")> kVelocityY;
constexpr ColumnKey<columnIndex("velocity_z")> kVelocityZ;
constexpr ColumnKey<columnIndex("radial_velocity")> kRadialVelocity;

TEST_F(MovingRun, PointsSayHowFastTheirThingMoves) {
  const Manifest m = sound({kColumns, "motion=per_column"});
  std::map<std::uint32_t, std::size_t> points;
  for (const Scan& s : scans()) {
    for (std::size_t i = 0; i < s.size(); ++i) {
      ++points[s[kInstance][i]];
      const Vec3d v{s[kVelocityX][i], s[kVelocityY][i], s[kVelocityZ][i]};
      const Vec3d wanted = s[kInstance][i] == 1 ? Vec3d{5, 0, 0} : s[kInstance][i] == 2 ? Vec3d{0, -3, 0} : Vec3d{};
      ASSERT_NEAR(length(v - wanted), 0, 1e-5) << s[kInstance][i];
    }
  }
  EXPECT_GT(points[1], 5u);
  EXPECT_GT(points[2], 10u);
  EXPECT_GT(points[3], 5u);
}

// The rate at which the distance changes, whatever frame the points are given in: the car's velocity minus the
// sensor's 20 m/s along x, along the beam.
TEST_F(MovingRun, RadialVelocitiesAreRelativeToTheSensor) {
  const std::string columns = "output.columns=[instance, ring, column, range_true, radial_velocity]";
  std::vector<std::vector<float>> inEachFrame;
  for (const char* motion : {"motion=per_column", "motion={steps: per_column, deskew: true}", "motion=none"}) {
    sound({columns, motion}, motion);
    std::vector<float>& all = inEachFrame.emplace_back();
    std::set<std::uint32_t> met;
    for (const Scan& s : scans(".pcd", motion)) {
      for (std::size_t i = 0; i < s.size(); ++i) {
        all.push_back(s[kRadialVelocity][i]);
        met.insert(s[kInstance][i]);
        if (std::string(motion).find("deskew") != std::string::npos) continue;
        const Vec3d thing = s[kInstance][i] == 1 ? Vec3d{5, 0, 0} : s[kInstance][i] == 2 ? Vec3d{0, -3, 0} : Vec3d{};
        const Vec3d along = normalized(Vec3d(s.position[i]));
        ASSERT_NEAR(s[kRadialVelocity][i], dot(along, thing - Vec3d{20, 0, 0}), 1e-4) << motion << s[kInstance][i];
      }
    }
    EXPECT_THAT(met, testing::IsSupersetOf({0u, 1u, 2u, 3u}));
  }
  EXPECT_EQ(inEachFrame[0], inEachFrame[1]);
}

// Points that stand still beside a sensor that stands still have none; nor has the ego vehicle, however fast it is.
TEST_F(MovingRun, RadialVelocitiesOfWhatMovesWithTheSensorAreZero) {
  const std::string columns = "output.columns=[instance, cause, radial_velocity]";
  sound({columns, "scenes.0.moving=false", "trajectories=[{name: drive, poses: [{}]}]"}, "still");
  for (const Scan& s : scans(".pcd", "still")) EXPECT_THAT(s[kRadialVelocity], testing::Each(0.0f));
  folder_.write(
      "scenes/hood.yaml",
      fmt::format("ontology: {0}/labels/scanmill.yaml\nmaterials: {0}/labels/materials.yaml\nobjects: [{{name: "
                  "hood, primitive: box, size: [3, 2, 1], class: car, material: car_paint, position: [2, 0, 0.8]}}]\n",
                  SCANMILL_SOURCE_DIR));
  sound({columns, "vehicle=scenes/hood.yaml"}, "hood");
  std::size_t own = 0;
  for (const Scan& s : scans(".pcd", "hood")) {
    for (std::size_t i = 0; i < s.size(); ++i) {
      if (s[kCause][i] != 5) continue;
      ++own;
      ASSERT_EQ(s[kRadialVelocity][i], 0);
    }
  }
  EXPECT_GT(own, 10u);
}

TEST_F(MovingRun, StandsWhereTheDriveBeginsIfThePipelineSaysSo) {
  const std::vector<std::string> still{kColumns, "scenes.0.moving=false",
                                       fmt::format("labels={}/labels/semantic_kitti.yaml", SCANMILL_SOURCE_DIR)};
  const Manifest m = sound(still);
  for (const Scan& s : scans()) {
    for (std::size_t i = 0; i < s.size(); ++i) {
      ASSERT_EQ(s[kVelocityX][i], 0);
      ASSERT_NE(s[kLabel][i], 252);
    }
  }
  // Then every method takes it.
  std::vector<std::string> particles = still;
  particles.emplace_back("method=particle");
  sound(particles, "particles");
  EXPECT_THAT(messageOf([&] { run({"method=particle"}, "no"); }),
              AllOf(HasSubstr("moving: false"), HasSubstr("ray_tracing")));
}

}  // namespace
}  // namespace scanmill
