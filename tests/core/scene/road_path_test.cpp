#include "scene/road_path.h"

#include <fmt/core.h>

#include "base/path.h"
#include "scenefile/scene_file.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// On a lawn: a road 8 m wide that runs from x = -50 to 104 at y = 0 and climbs by 0.05 m a metre, and one that leaves
// its end at x = 100 to the left up to y = 80, level. A parked car stands on the first one, in the right lane.
class RoadPath : public testing::Test {
 protected:
  RoadPath() {
    const std::string roads =
        R"(  - {name: lawn, primitive: plane, size: [400, 400], class: terrain, material: grass, position: [0, 0, -3]}
  - {name: first, primitive: plane, size: [154.1923, 8], class: road, material: asphalt, position: [27, 0, 1.35], pitch_deg: -2.862405}
  - {name: second, primitive: plane, size: [8, 84], class: road, material: asphalt, position: [100, 42, 5]}
  - {name: far, primitive: plane, size: [8, 40], class: road, material: asphalt, position: [-150, 0, 0]}
  - {name: parked, primitive: box, size: [4, 1.8, 1.5], class: car, material: car_paint, position: [20, -2.5, 1.75]}
)";
    SceneOptions options;
    options.seed = 1;
    scene_ = readScene(folder_.write("roads.yaml", sceneYaml(roads)), options);
  }
  std::vector<Vec3d> path(const Vec3d& from, const Vec3d& to, RoadSide keep = RoadSide::Right) const {
    SurfaceHeights heights(scene_);
    heights.update();
    return findRoadPath(heights, scene_.ontology, {{"road"}, from, to, keep, {"roads.yaml", 7, 1}});
  }
  std::string refusal(const Vec3d& from, const Vec3d& to) const {
    return messageOf([&] { path(from, to); });
  }
  static double roadHeight(const Vec3d& p) { return p.x < 96 ? 0.05 * p.x : 5; }

  TemporaryFolder folder_;
  Scene scene_;
};

// A vehicle of 2 m keeps within the two roads, clear of the car, and 2 m from the edge on its side.
TEST_F(RoadPath, LeadsAlongRoadsOnTheirRightSide) {
  const std::vector<Vec3d> points = path({-40, 0, 0}, {100, 70, 0});
  EXPECT_LT(std::hypot(points.front().x + 40, points.front().y), 2.6);
  EXPECT_LT(std::hypot(points.back().x - 100, points.back().y - 70), 2.6);
  const Path way(points);
  EXPECT_NEAR(way.length(), 140 + 70, 12);
  for (double at = 0; at <= way.length(); at += 0.5) {
    const Vec3d p = way.pose(at).translation;
    EXPECT_NEAR(p.z, roadHeight(p), 0.25) << at;
    if (p.x < 96) {
      EXPECT_LT(std::fabs(p.y), 3.1) << at;
    }
    if (p.y > 4) {
      EXPECT_LT(std::fabs(p.x - 100), 3.1) << at;
    }
    const double toCar = std::hypot(std::max(std::fabs(p.x - 20) - 2, 0.0), std::max(std::fabs(p.y + 2.5) - 0.9, 0.0));
    EXPECT_GT(toCar, 0.85) << p.x << " " << p.y;
    if (p.x > -30 && p.x < 5) {
      EXPECT_NEAR(p.y, -2, 0.3) << at;
    }
    if (p.y > 20 && p.y < 60) {
      EXPECT_NEAR(p.x, 102, 0.3) << at;
    }
  }
}

TEST_F(RoadPath, KeepsToTheSideThatIsAskedFor) {
  for (const auto& [keep, y] : {std::pair{RoadSide::Right, 2.0}, {RoadSide::Left, -2.0}, {RoadSide::Middle, 0.0}}) {
    const Path back(path({90, 0, 0}, {40, 0, 0}, keep));
    EXPECT_NEAR(back.pose(back.length() / 2).translation.y, y, 0.3) << "towards -x";
  }
}

TEST_F(RoadPath, NoWayIsRefused) {
  EXPECT_THAT(refusal({-40, 0, 0}, {-150, 0, 0}), testing::AllOf(HasSubstr("roads.yaml:7"), HasSubstr("no path")));
  EXPECT_THAT(refusal({-40, 0, 0}, {-40, 90, 0}), HasSubstr("`to`: within 20 m"));
  EXPECT_THAT(messageOf([&] {
                SurfaceHeights heights(scene_);
                findRoadPath(heights, scene_.ontology, {{"rood"}, {}, {}, RoadSide::Right, {"roads.yaml", 7, 1}});
              }),
              HasSubstr("did you mean 'road'"));
}

// Rays that are exactly on the seam between two tiles of a town may miss both tiles: a path crosses it all the same.
TEST_F(RoadPath, LeadsAcrossTheSeamsOfTiles) {
  SKIP_WITHOUT_SHARED_DATA("scenes/kenney_city/road-straight.glb");
  const std::string folder = (sharedData() / "scenes/kenney_city").string();
  std::string tiles = fmt::format(
      "  - {{name: crossing, file: \"{}/road-intersection.glb\", unit: 12, class: road, material: asphalt}}\n", folder);
  for (const int x : {-36, -24, -12, 12, 24, 36}) {
    tiles += fmt::format(
        "  - {{name: road, file: \"{}/road-straight.glb\", unit: 12, class: road, material: asphalt, position: [{}, 0, "
        "0], yaw_deg: 90}}\n",
        folder, x);
  }
  const Scene scene = readScene(folder_.write("tiles.yaml", sceneYaml(tiles)), {});
  SurfaceHeights heights(scene);
  heights.update();
  for (const double start : {-40.0, -39.5}) {  // m; cells of 1 m from the first one lie on all seams
    const Path way(findRoadPath(heights, scene.ontology, {{"road"}, {start, -2.6, 0}, {40, -2.6, 0}, {}, {}}));
    EXPECT_NEAR(way.length(), 40 - start, 3);
  }
}

// The heights of the ground between the points too: a lawn below, and roads above it.
TEST_F(RoadPath, PointsDropOnTheGround) {
  SurfaceHeights heights(scene_);
  heights.update();
  const std::vector<Vec3d> points = droppedOnGround(heights, {{0, -20.5, 9}, {0, 19.5, 9}}, {"roads.yaml", 7, 1});
  ASSERT_EQ(points.size(), 41u);
  for (const Vec3d& p : points) EXPECT_NEAR(p.z, std::fabs(p.y) < 4 ? 0.05 * p.x : -3, 1e-6) << p.y;
  EXPECT_THAT(messageOf([&] {
                droppedOnGround(heights, {{0, 0, 0}, {300, 0, 0}}, {"roads.yaml", 7, 1});
              }),
              HasSubstr("no ground below"));
}

// Vehicles on the road: a row at rest beside it, and a row that drives from the one point to the other.
TEST_F(RoadPath, ObjectsDriveAndParkAlongIt) {
  const std::string roads =
      R"(  - {name: lawn, primitive: plane, size: [400, 400], class: terrain, material: grass, position: [0, 0, -3]}
  - {name: first, primitive: plane, size: [154.1923, 8], class: road, material: asphalt, position: [27, 0, 1.35], pitch_deg: -2.862405}
  - {name: van, primitive: box, size: [5, 2, 2], class: car, material: car_paint, position: [0, 0, 1], moving: {from: [-40, 0], to: [90, 0], on: road, speed: 10, start: [0, 20, 45]}}
  - {name: taxi, primitive: box, size: [4, 2, 1.4], class: car, material: car_paint, stand_on: ground, copies: {along: {from: [-40, 0], to: [90, 0], on: road, keep: left, every: 10}}}
  - {name: dog, primitive: box, size: [1, 1, 1], class: animal, material: wood, position: [0, 0, 0.5], moving: {waypoints: [[0, -20, 50], [0, 20, 50]], speed: 2, ground: drop}}
)";
  SceneOptions options;
  const Scene scene = readScene(folder_.write("traffic.yaml", sceneYaml(roads)), options);
  std::vector<const Instance*> vans;
  int taxis = 0;
  for (const Instance& i : scene.instances) {
    if (i.name.starts_with("van")) vans.push_back(&i);
    if (i.name == "dog") {
      for (const double time : {0.0, 4.0, 9.0, 12.0}) {
        const Vec3d at = i.worldFromMeshAt(time).translation;
        EXPECT_NEAR(at.y, -20 + 2 * time, 3.2) << "the way up to the road counts";
        EXPECT_NEAR(at.z - 0.5, std::fabs(at.y) < 4 ? 0 : -3, std::fabs(std::fabs(at.y) - 4) < 1.6 ? 3.1 : 0.1) << time;
      }
    }
    if (!i.name.starts_with("taxi")) continue;
    ++taxis;
    const Vec3d at = i.worldFromMesh.translation;
    EXPECT_NEAR(at.y, 2, 0.4);
    EXPECT_NEAR(at.z, 0.05 * at.x + 0.7, 0.2) << "stands on the road";
  }
  EXPECT_EQ(taxis, 14);
  ASSERT_EQ(vans.size(), 3u);
  for (const double time : {0.0, 3.0, 6.0}) {
    const double first = vans[0]->worldFromMeshAt(time).translation.x;
    EXPECT_NEAR(first, -40 + 10 * time, 1.5);
    EXPECT_NEAR(vans[1]->worldFromMeshAt(time).translation.x - first, 20, 0.6);
    EXPECT_NEAR(vans[2]->worldFromMeshAt(time).translation.x - first, 45, 0.6);
    for (const Instance* van : vans) {
      const Vec3d at = van->worldFromMeshAt(time).translation;
      EXPECT_NEAR(at.z - 1, 0.05 * at.x, 0.15);
      EXPECT_NEAR(at.y, -2, 0.5);
    }
  }
  const auto refusal = [&](const std::string& moving) {
    const std::string object =
        "  - {name: van, primitive: box, size: [5, 2, 2], class: car, material: car_paint, moving: {" + moving + "}}\n";
    const std::string text = sceneYaml(roads.substr(0, roads.find("  - {name: van")) + object);
    return messageOf([&] { readScene(folder_.write("bad.yaml", text), options); });
  };
  EXPECT_THAT(refusal("from: [0, 0], to: [9, 0], on: road, speed: 3, velocity: [1, 0, 0]"),
              HasSubstr("velocity has no"));
  EXPECT_THAT(refusal("from: [0, 0], on: road, speed: 3, ground: drop, waypoints: [[0, 0, 0], [9, 0, 0]]"),
              HasSubstr("from has no effect beside `waypoints`"));
  EXPECT_THAT(refusal("to: [9, 0], on: road, speed: 3"), HasSubstr("'from' is missing"));
  EXPECT_THAT(refusal("from: [0, 0], to: [9, 0], on: road, speed: 3, start: [0, 99]"), HasSubstr("start"));
}

}  // namespace
}  // namespace scanmill
