#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "sensors/trajectory.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class OnWheels : public Yard {
 protected:
  // Returns the mean slope (degrees) of the ground from the right to the left wheels in the vehicle's frame, over the
  // frames of a drive with the trajectory `trajectory` in a town with the parameters `town`.
  double meanSlope(const std::string& town, const std::string& trajectory) const {
    folder_.write("scenes/town.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\n"
                                                  "materials: {0}/labels/materials.yaml\n"
                                                  "objects: [{{town: {{{1}, people: 0, detail: 0.05}}}}]\n",
                                                  SCANMILL_SOURCE_DIR, town));
    const Plan plan =
        planOf({"scenes=[{scene: scenes/town.yaml, seeds: [5]}]", "trajectories=[{name: a, " + trajectory + "}]"});
    ShotSource source(plan);
    const Scene scene = source.load(0);
    const SceneGround ground(scene, {});
    const auto path = source.trajectory(0);
    double sum = 0;
    for (std::uint32_t frame = 0; frame < path->frames(); ++frame) {
      const Pose vehicle = path->pose(frame, 0);
      const auto heightAt = [&](double y) {  // of the ground in the vehicle's frame
        const Vec3d point = vehicle * Vec3d{0, y, 0};
        return (inverse(vehicle) * Vec3d{point.x, point.y, *ground.under(point)}).z;
      };
      sum += degrees(std::atan2(heightAt(0.8) - heightAt(-0.8), 1.6));
    }
    return sum / path->frames();
  }
};

// In each kind of town, driven on either side, on a map, with turns and by waypoints, the road is level for a vehicle
// that is not told how to stand; without wheels, it is as steep as the road's cross fall.
TEST_F(OnWheels, RoadsAreLevelForVehiclesThatDrive) {
  const std::string lane = "along: lane, speed: 10, every_m: 5, frames: 20";
  for (const char* kind :
       {"rural", "suburban", "dense", "boulevard", "old_town", "arterial", "commercial", "motorway"}) {
    EXPECT_LT(std::fabs(meanSlope(fmt::format("length: 120, district: {}", kind), lane)), 0.3) << kind;
  }
  EXPECT_LT(std::fabs(meanSlope("length: 120, district: arterial, driving_side: left", lane)), 0.3);
  EXPECT_LT(std::fabs(meanSlope("length: 120, district: arterial", "along: turns, speed: 8, every_m: 5")), 0.3);
  EXPECT_LT(std::fabs(meanSlope("length: 120, district: arterial", "on: road, speed: 8, every_m: 5, frames: 20")), 0.3);
  EXPECT_LT(std::fabs(meanSlope(fmt::format("length: 120, map: {}/scenes/village.osm", SCANMILL_SOURCE_DIR), lane)),
            0.3);
  EXPECT_GT(std::fabs(meanSlope("length: 120, district: arterial", lane + ", ground: none")), 0.5);
}

}  // namespace
}  // namespace scanmill
