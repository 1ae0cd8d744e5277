// The objects that a sample lists: boxes, tracks, names.

#include <fmt/core.h>

#include "tests/studio/viewer/window/session_world.h"
#include "viewer/window/session_items.h"

namespace scanmill {
namespace {

constexpr std::size_t kEdges = 12;

// A car that is seen, with a front and a track, and a tree that is not.
std::shared_ptr<FakeFrames> listedFrames() {
  auto frames = std::make_shared<FakeFrames>(2);
  ViewObject car;
  car.record.id = 4711;
  car.record.semantic = kFakeCar;
  car.record.name = "estate";
  car.record.moves = true;
  car.record.worldFromBox = {{}, {10, 90, 1}};
  car.record.size = {4, 2, 1.5};
  car.record.velocity = {3, 4, 0};
  ObjectView view;
  view.sensor = "top";
  view.sensorFromBox = {{}, {10, -10, -0.8}};
  view.points = view.beams = 30;
  view.beamsAlone = 60;
  car.record.views = {view};
  car.track = {{8, 90, 1}, {10, 90, 1}, {12, 90, 1}};
  ViewObject tree;
  tree.record.id = 5;
  tree.record.semantic = kFakeTree;
  tree.record.headingKnown = false;
  tree.record.worldFromBox = {{}, {5, 110, 1}};
  tree.record.size = {1, 1, 3};
  frames->frames[0].objects = {car, tree};
  return frames;
}

const FakeCanvas::Item& boxes(const SessionWorld& world) {
  return world.canvas.items.at(kBoxesItem);
}

TEST(SessionBoxes, AreDrawnInTheColoursOfTheirClasses) {
  SessionWorld world(listedFrames(), {.sample = "0", .boxes = BoxChoice::All});
  const auto& colors = boxes(world).colors;
  ASSERT_EQ(colors.size(), kEdges + 1 + 2 + kEdges) << "two boxes, a front, a track of three places";
  EXPECT_EQ(std::ranges::count(colors, kFakeCarColor), static_cast<long>(kEdges + 3));
  EXPECT_EQ(std::ranges::count(colors, kFakeTreeColor), 0) << "nothing is seen of it: it is faint";
  // As the points of its sensor lie: 10 m ahead and 10 m to the right of it.
  Box car;
  for (std::size_t i = 0; i < 2 * kEdges; ++i) car.add(Vec3d(boxes(world).places[i]));
  EXPECT_NEAR(length(car.center() - Vec3d{10, -10, -0.8}), 0, 1e-5);
  EXPECT_NEAR(length(car.high - car.low - Vec3d{4, 2, 1.5}), 0, 1e-5);
}

// Points that were placed by the poses of their columns, and the box of what they are on.
TEST(SessionBoxes, FitPointsOfAMovingSensor) {
  const auto frames = listedFrames();
  ViewScan& scan = frames->frames[0].scans[0];
  scan.placed = scan.scan.position;
  for (Vec3f& place : scan.placed) place.x += 3;
  frames->frames[0].objects[0].record.views[0].time = 0.55;
  frames->frames[0].objectTime = 0.5;
  const SessionWorld world(frames, {.sample = "0"});
  EXPECT_EQ(world.canvas.items.at(firstCloud(world)).places, scan.placed);
  Box car;
  for (std::size_t i = 0; i < 2 * kEdges; ++i) car.add(Vec3d(boxes(world).places[i]));
  EXPECT_NEAR(length(car.center() - Vec3d{10.15, -9.8, -0.8}), 0, 1e-5) << "as far as it moves in 0.05 s";
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72);
  const auto thing = world.session->pick(x, y);
  ASSERT_TRUE(thing);
  EXPECT_EQ(thing->place, Vec3d(scan.placed[thing->point]));
  EXPECT_EQ(rowOf(*thing, "x"), fmt::format("{:.3f} m", scan.scan.position[thing->point].x)) << "as the file has it";
}

// Views are of the sensor's first revolution.
TEST(SessionBoxes, FitPointsOfALaterRevolution) {
  const auto frames = listedFrames();
  ViewScan& scan = frames->frames[0].scans[0];
  scan.revolution = 1;
  scan.time = 0.6;
  frames->frames[0].objects[0].record.views[0].time = 0.55;
  frames->frames[0].objectTime = 0.5;
  const SessionWorld world(frames, {.sample = "0"});
  Box car;
  for (std::size_t i = 0; i < 2 * kEdges; ++i) car.add(Vec3d(boxes(world).places[i]));
  EXPECT_NEAR(length(car.center() - Vec3d{10.3, -9.6, -0.8}), 0, 1e-5) << "as far as it moves in 0.1 s";
}

TEST(SessionBoxes, FollowKeysAndFilters) {
  SessionWorld world(listedFrames(), {.sample = "0"});
  const auto drawn = [&] { return boxes(world).colors.size(); };
  EXPECT_EQ(drawn(), kEdges + 3) << "the car alone: a tree is no road user";
  world.key("O");
  EXPECT_EQ(drawn(), 2 * kEdges + 3) << "all";
  world.key("O");
  EXPECT_EQ(drawn(), 0u);
  world.key("O");
  EXPECT_EQ(drawn(), kEdges + 3);
  world.press("Right");
  EXPECT_EQ(drawn(), 0u) << "the next sample lists nothing";
  const SessionWorld cars(listedFrames(), {.sample = "0", .boxes = BoxChoice::All, .hidden = {"tree"}});
  EXPECT_EQ(boxes(cars).colors.size(), kEdges + 3);
  const SessionWorld alone(listedFrames(), {.sample = "0", .instances = {5}});
  EXPECT_EQ(boxes(alone).colors.size(), kEdges);
}

// The own vehicle stands below its sensor as long as axes are on.
TEST(SessionVehicle, IsDrawnWhereItIs) {
  const auto frames = std::make_shared<FakeFrames>(2);
  frames->vehicleFile = std::filesystem::path(SCANMILL_SOURCE_DIR) / "scenes/vehicle.yaml";
  frames->frames[0].worldFromVehicle =
      Pose{{}, {0.5, 100, 0}};  // the sensor is 0.5 m behind its origin and 1.8 m above
  SessionWorld world(frames, {.sample = "0"});
  const FakeCanvas::Item& item = world.canvas.items.at(kVehicleItem);
  Box shown;
  for (const Vec3f& corner : item.places) shown.add(item.look.canvasFromItem * Vec3d(corner));
  EXPECT_NEAR(length(shown.low - Vec3d{-1.7, -0.9, 0.275 - 1.8}), 0, 1e-5);
  EXPECT_NEAR(length(shown.high - Vec3d{3.1, 0.9, 1.53 - 1.8}), 0, 1e-5);
  world.key("a");
  EXPECT_FALSE(world.canvas.items.contains(kVehicleItem));
  world.key("a");
  EXPECT_TRUE(world.canvas.items.contains(kVehicleItem));
  world.press("Right");
  EXPECT_FALSE(world.canvas.items.contains(kVehicleItem)) << "the next sample has none";
}

TEST(SessionBoxes, PickingTellsTheObject) {
  SessionWorld world(listedFrames(), {.sample = "0"});
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72 + 70);
  world.click(x, y);
  const std::optional<PickedThing> thing = world.session->pick(x, y);
  ASSERT_TRUE(thing.has_value());
  EXPECT_EQ(rowOf(*thing, "object"), "estate");
  EXPECT_EQ(rowOf(*thing, "box"), "4.00 x 2.00 x 1.50 m");
  EXPECT_EQ(rowOf(*thing, "speed"), "5.00 m/s");
  EXPECT_EQ(rowOf(*thing, "visible"), "50 % (30 of 60 beams)");
}

}  // namespace
}  // namespace scanmill
