#include <fmt/format.h>

#include <numbers>

#include "pipeline/checks/box_sweep.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/labels.h"

namespace scanmill {
namespace {

class PathWarnings : public Yard {
 protected:
  std::vector<std::string> warnings(const std::vector<std::string>& overrides) const {
    const Plan plan = planOf(overrides);
    ShotSource source(plan);
    const Scene scene = source.load(0);
    return pathWarnings(source, 0, SceneProbe(scene));
  }
  static std::string drive(const std::string& waypoints, const std::string& more = "") {
    return "trajectories=[{name: drive, waypoints: " + waypoints + ", speed: 20, every_s: 0.1" + more + "}]";
  }
};

TEST_F(PathWarnings, AreSilentWhereAllIsWell) {
  EXPECT_THAT(warnings({}), IsEmpty());
  EXPECT_THAT(warnings({"trajectories=[{poses: [{position: [3, 4, 0]}]}]"}), IsEmpty());
  EXPECT_THAT(warnings({drive("[[-10, 0, 9], [10, 0, -7]]", ", ground: drop")}), IsEmpty());
}

TEST_F(PathWarnings, TellOfSensorsUnderTheGround) {
  EXPECT_THAT(warnings({drive("[[-10, 0, -4], [10, 0, -4]]")}),
              ElementsAre(AllOf(HasSubstr("sequence yard-s1-drive"), HasSubstr("'top' is below the ground"),
                                HasSubstr("11 of 11 frames"), HasSubstr("class ground is 2.2 m above"),
                                HasSubstr("`ground: drop`"))));
  EXPECT_THAT(
      warnings({drive("[[-10, 0, 0], [10, 0, 0]]", ", ground: drop"), "sensors.0.mount={position: [0, 0, -2]}"}),
      ElementsAre(AllOf(HasSubstr("'top' is below the ground"), HasSubstr("place its `mount` above"))));
  EXPECT_THAT(
      warnings({drive("[[-10, 0, 0], [10, 0, 0]]", ", ground: drop"), "sensors.0.mount=null"}),
      ElementsAre(AllOf(HasSubstr("'top' is on the surface of something of the class ground in 11 of 11 frames"),
                        HasSubstr("`mount`"))));
  // A sensor that is mounted at this height may touch something else.
  EXPECT_THAT(warnings({"trajectories=[{poses: [{position: [8, 5, 0]}]}]", "sensors.0.mount={position: [0, 0, 1.52]}"}),
              Contains(AllOf(HasSubstr("'top' is on the surface of 'car#1' (car) in 1 of 1 frames"),
                             Not(HasSubstr("`mount`")))));
}

TEST_F(PathWarnings, TellOfWaypointsThatAreMovedToTheGround) {
  EXPECT_THAT(warnings({drive("[[-10, 0, 0.3], [10, 0, 0.3]]")}),
              ElementsAre(AllOf(HasSubstr("0.30 m from its waypoints"), HasSubstr("`ground: none`"))));
  EXPECT_THAT(warnings({drive("[[-10, 0, 0.3], [10, 0, 0.3]]", ", ground: none")}), IsEmpty());
}

TEST_F(PathWarnings, TellOfSensorsFarAboveAndBeside) {
  EXPECT_THAT(warnings({drive("[[-10, 0, 90], [10, 0, 90]]")}), IsEmpty()) << "an aircraft";
  EXPECT_THAT(warnings({drive("[[-10, 0, 900], [10, 0, 900]]")}),
              ElementsAre(HasSubstr("'top' is 881.8 m away from the scene")));
  EXPECT_THAT(warnings({drive("[[500, 0, 0], [510, 0, 0]]")}),
              ElementsAre(AllOf(HasSubstr("'top' is 460 m away from the scene"), HasSubstr("[500.00, 0.00, 1.80]"))));
  EXPECT_THAT(warnings({drive("[[100, 0, 0], [110, 0, 0]]")}), IsEmpty()) << "it may see the yard from there";
}

TEST_F(PathWarnings, TellOfSensorsInsideOfThings) {
  EXPECT_THAT(warnings({"trajectories=[{poses: [{position: [8, 5, -1]}]}]"}),
              Contains(HasSubstr("'top' sees nothing beside and above it but surfaces of the class car, such as "
                                 "'car#1' (car), at [8.00, 5.00, 0.80]")));
}

// A tower whose walls and roof are objects of their own, and a rail that is lower than most of a car.
TEST_F(PathWarnings, TellOfTowersOfSeveralPartsAndOfLowRails) {
  const auto box = [](const std::string& name, const char* size, const char* at, const char* semantic) {
    return fmt::format("  - {{name: {}, primitive: box, size: [{}], position: [{}], class: {}, material: concrete}}\n",
                       name, size, at, semantic);
  };
  std::string objects = box("ground", "99, 99, 1", "0, 0, -0.5", "ground");
  objects += box("roof", "6, 6, 0.2", "0, 0, 5", "building");
  for (const auto& [size, at] : {std::pair{"6, 0.2, 5", "0, 3, 2.5"},
                                 {"6, 0.2, 5", "0, -3, 2.5"},
                                 {"0.2, 6, 5", "3, 0, 2.5"},
                                 {"0.2, 6, 5", "-3, 0, 2.5"}}) {
    objects += box("wall", size, at, "building");
  }
  objects += box("rail", "0.1, 20, 0.5", "10, 0, 0.25", "fence");
  const std::string scene = folder_.write("tower.yaml", sceneYaml(objects)).string();
  EXPECT_THAT(warnings({"scenes.0.scene=" + scene, "trajectories=[{poses: [{position: [0, 0, 0.5]}]}]"}),
              ElementsAre(HasSubstr("'top' sees nothing beside and above it but surfaces of the class building")));
  EXPECT_THAT(warnings({"scenes.0.scene=" + scene, "trajectories=[{poses: [{position: [0, 7, 0.5]}]}]"}), IsEmpty());
  EXPECT_THAT(warnings({"scenes.0.scene=" + scene, drive("[[20, 0, 0], [5, 0, 0]]", ", ground: drop")}),
              ElementsAre(HasSubstr("its path goes through 'rail' (fence) at [10.05, ")));
}

TEST_F(PathWarnings, TellOfWaysThroughWallsAndLowThings) {
  EXPECT_THAT(warnings({drive("[[0, 0, 0], [45, 0, 0]]")}),
              Contains(HasSubstr("its path goes through 'across#1' (wall) at [30.00, 0.00")));
  // Both cars of the yard, one behind the other, however often it comes by; and a circle that one frame is long.
  EXPECT_THAT(warnings({"trajectories=[{name: loop, path: line, waypoints: [[-10, 5, 0], [20, 5, 0], [20, 9, 0], "
                        "[-10, 9, 0], [-10, 5.1, 0]], speed: 20, every_m: 60}]"}),
              Contains(AllOf(HasSubstr("'car#1' (car) at [6.00, 5.00, "), HasSubstr("(frame 0)"))));
  // The cars are lower than the sensor.
  EXPECT_THAT(warnings({drive("[[-10, 5, 0], [20, 5, 0]]")}),
              ElementsAre(AllOf(HasSubstr("'car#1' (car) at [6.00, 5.00, "))));
  // What moves may have gone by then.
  folder_.write("scenes/yard.yaml", yardScene() + "    moving: {velocity: [1, 0, 0]}\n");
  EXPECT_THAT(warnings({drive("[[-10, 5, 0], [20, 5, 0]]")}), IsEmpty());
}

// A room with a coffee table, whose plate is thin and whose legs stand beside the robot's path, a bed that no class
// tells from the ground, a sill that wheels climb, and a wall.
TEST_F(PathWarnings, TellWhatTheVehicleMeetsFirst) {
  const auto box = [](const std::string& name, const char* size, const char* at, const char* semantic) {
    return fmt::format("  - {{name: {}, primitive: box, size: [{}], position: [{}], class: {}, material: concrete}}\n",
                       name, size, at, semantic);
  };
  std::string objects = box("floor", "20, 20, 1", "0, 0, -0.5", "ground");
  objects += box("sill", "0.05, 20, 0.03", "0, 0, 0.015", "structure");
  objects += box("plate", "1, 0.6, 0.03", "2, 0, 0.345", "object");
  for (const char* const at : {"1.55, 0.33, 0.165", "2.45, 0.33, 0.165", "1.55, -0.33, 0.165", "2.45, -0.33, 0.165"}) {
    objects += box("leg", "0.05, 0.05, 0.33", at, "object");
  }
  objects += box("bed", "2, 1.6, 0.45", "2, 4, 0.225", "structure");
  objects += box("wall", "0.3, 20, 2.5", "6, 0, 1.25", "wall");
  const std::string scene = folder_.write("room.yaml", sceneYaml(objects)).string();
  folder_.write("robot.yaml",
                sceneYaml("  - {name: hull, primitive: box, size: [0.5, 0.4, 0.3], position: [0, 0, 0.2], "
                          "class: ego_vehicle, material: concrete}\n"));
  const auto told = [&](const std::string& trajectory, const std::string& vehicle = "vehicle=robot.yaml") {
    return warnings({"scenes.0.scene=" + scene, "sensors.0.mount={position: [0, 0, 0.42]}",
                     "trajectories=[{" + trajectory + ", ground: {wheels: [0.4, 0.3]}}]", vehicle});
  };
  const std::string speed = ", speed: 1, every_s: 0.2";
  EXPECT_THAT(told("waypoints: [[-3, -3, 0], [5, -3, 0]]" + speed), IsEmpty());
  EXPECT_THAT(told("waypoints: [[-3, 0, 0], [5, 0, 0]]" + speed),
              ElementsAre(AllOf(HasSubstr("its path goes through 'plate' (object) at ["), HasSubstr("(frame 21)"),
                                HasSubstr("the box of its `vehicle`, 0.50 x 0.40 m, from 0.10 to 0.35 m"))));
  folder_.write("sunk.yaml", sceneYaml("  - {name: hull, primitive: box, size: [0.5, 0.4, 0.3], class: ego_vehicle, "
                                       "material: concrete}\n"));
  EXPECT_THAT(told("waypoints: [[-3, -3, 0], [5, -3, 0]]" + speed, "vehicle=sunk.yaml"),
              ElementsAre(AllOf(HasSubstr("reaches 0.15 m under the ground"), HasSubstr("{height: 0.150}"))));
  // The robot is wide enough to touch a leg, in whichever direction it drives.
  EXPECT_THAT(told("waypoints: [[2.45, -3, 0], [2.45, -0.6, 0]]" + speed),
              ElementsAre(HasSubstr("'leg' (object) at [2.4")));
  // Without a model of the vehicle, its sensors and the wheels that are given.
  EXPECT_THAT(told("waypoints: [[-3, -0.47, 0], [5, -0.47, 0]]" + speed, "vehicle=null"),
              ElementsAre(AllOf(HasSubstr("'leg' (object) at [1.5"),
                                HasSubstr("its sensors, 0.40 x 0.30 m, from 0.10 to 0.42"))));
  EXPECT_THAT(told("waypoints: [[-3, -0.55, 0], [5, -0.55, 0]]" + speed, "vehicle=null"), IsEmpty());
  EXPECT_THAT(told("waypoints: [[-3, 4, 0], [5, 4, 0]]" + speed),
              Contains(HasSubstr("its path goes through 'bed' (structure) at [1.00, 4.00")));
  EXPECT_THAT(told("poses: [{position: [5.74, -5, 0]}]"),
              ElementsAre(HasSubstr("it stands in 'wall' (wall) at [5.85,")));
  EXPECT_THAT(told("poses: [{position: [5.5, -5, 0]}]"), IsEmpty());
  EXPECT_THAT(told("poses: [{position: [5.5, -5, 0], yaw_deg: 45}, {position: [5.6, -5, 0], yaw_deg: 45}]"),
              ElementsAre(HasSubstr("(frame 1)")))
      << "its corner";
}

TEST_F(PathWarnings, BoxesTouchTheNearSideForwardsAndBackwards) {
  const Plan plan = planOf();
  const Scene scene = ShotSource(plan).load(0);
  for (const double yaw : {0.0, std::numbers::pi}) {
    const Quat heading = fromYawPitchRoll(yaw, 0, 0);
    const std::optional<BoxContact> contact =
        sweepBoxes(scene, {{{-0.5, -0.5, 0.5}, {0.5, 0.5, 1}}}, {{{heading, {3, 5, 0}}, {heading, {9, 5, 0}}}},
                   [](const Instance&, const Surface&, const Vec3d&) { return true; });
    ASSERT_TRUE(contact);
    EXPECT_EQ(contact->instance->name, "car#1");
    EXPECT_NEAR(contact->position.x, 6, 1e-6) << yaw;
  }
}

TEST_F(PathWarnings, TellHowFarLongWaysAreChecked) {
  EXPECT_THAT(warnings({"trajectories=[{name: far, path: line, waypoints: [[-3, 5, 0], [204000, 5, 0]], speed: 100, "
                        "every_m: 500}]"}),
              testing::IsSupersetOf({HasSubstr("only its frames 0 to 399 are checked for obstacles"),
                                     HasSubstr("'car#1' (car) at [6.00, 5.00, ")}));
}

TEST_F(PathWarnings, TellOfWaysThatLeaveTheGround) {
  EXPECT_THAT(warnings({drive("[[0, 0, 0], [0, 30, 0], [0, 70, 0]]", ", ground: drop")}),
              Contains(HasSubstr("% of its path has no ground below or above")));
}

TEST_F(PathWarnings, RandomDrivesMakeSoundDatasetsThatFollowFromTheSeed) {
  const std::string roam = "trajectories=[{name: roam, on: [ground], speed: 10, every_s: 0.2, frames: 12, drives: 2}]";
  sound({roam}, "one");
  sound({roam}, "two");
  EXPECT_EQ(members("one"), members("two"));
  const Manifest manifest = readManifest(out("one"));
  EXPECT_EQ(manifest.samples.size(), 24u);
  EXPECT_EQ(manifest.samples.back().key, "yard-s1-roam-1-000011");
}

}  // namespace
}  // namespace scanmill
