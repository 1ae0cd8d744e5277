// One instance among the points: shown alone, edged, measured, in a box; the objects that a sample lists; and the
// returns of one beam.

#include <fmt/core.h>

#include <set>

#include "tests/studio/viewer/window/session_world.h"
#include "viewer/window/canvas_items.h"
#include "viewer/window/session.h"

namespace scanmill {
namespace {

using Kind = CanvasEvent::Kind;

// Which points of the first cloud are shown, by their instances.
std::set<std::uint32_t> shownInstances(const SessionWorld& world, std::size_t frame) {
  std::set<std::uint32_t> instances;
  for (const std::uint32_t i : world.canvas.shownOf(firstCloud(world))) {
    instances.insert(world.frames->frames[frame].scans[0].scan[kInstance][i]);
  }
  return instances;
}

TEST(SessionInstances, OneAloneInAllFrames) {
  SessionWorld world(3);
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72 + 70);
  const std::set<std::uint32_t> all{0, 4711};
  const std::set<std::uint32_t> one{4711};
  world.pointer(Kind::Move, x, y);
  world.key("x");
  EXPECT_EQ(shownInstances(world, 1), one);
  world.press("Right");
  EXPECT_EQ(shownInstances(world, 2), one);
  EXPECT_TRUE(world.session->problems().empty());
  world.key("x");
  EXPECT_EQ(shownInstances(world, 2), all);
  for (const char* key : {"A", "Escape"}) {
    world.pointer(Kind::Move, x, y);
    world.key("x");
    EXPECT_EQ(shownInstances(world, 2), one);
    EXPECT_TRUE(world.key(key));
    EXPECT_EQ(shownInstances(world, 2), all);
  }
  world.pointer(Kind::Move, world.pixelOf(firstCloud(world), 6 * 72).first,
                world.pixelOf(firstCloud(world), 6 * 72).second);
  world.key("x");  // the road has none
  EXPECT_EQ(shownInstances(world, 2), all);
}

TEST(SessionInstances, OptionsJoinClassesAndInstances) {
  const SessionWorld one(1, {"ray_tracing"}, {.instances = {4711}});
  EXPECT_EQ(shownInstances(one, 0), (std::set<std::uint32_t>{4711}));
  const SessionWorld none(1, {"ray_tracing"}, {.hidden = {"car"}, .instances = {4711}});
  EXPECT_TRUE(none.canvas.shownOf(firstCloud(none)).empty());
  const SessionWorld absent(1, {"ray_tracing"}, {.instances = {5}});
  EXPECT_TRUE(absent.canvas.shownOf(firstCloud(absent)).empty());
  ASSERT_EQ(absent.session->problems().size(), 1u);
  EXPECT_NE(absent.session->problems()[0].find("instance 5"), std::string::npos);
}

// While the pointer is on an instance, its points are drawn once more, seen at the same pixels and behind themselves.
TEST(SessionInstances, PointedAtTheyStandOut) {
  for (const bool orthographic : {false, true}) {
    SessionWorld world(1);
    if (orthographic) world.key("o");
    const Scan& scan = world.frames->frames[0].scans[0].scan;
    const auto car = world.pixelOf(firstCloud(world), 3 * 72 + 70);
    world.pointer(Kind::Move, 5, 80);
    world.session->drawWhenLoaded();
    EXPECT_EQ(world.canvas.pointItems().size(), 1u);
    const auto edge = [&]() -> const FakeCanvas::Item* {
      world.pointer(Kind::Move, car.first, car.second);
      world.session->drawWhenLoaded();
      const auto items = world.canvas.pointItems();
      return items.size() == 2 ? &world.canvas.items.at(items[1]) : nullptr;
    };
    const FakeCanvas::Item* lit = edge();
    ASSERT_NE(lit, nullptr);
    std::vector<Vec3f> held;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (scan[kInstance][i] == 4711) held.push_back(scan.position[i]);
    }
    EXPECT_EQ(lit->places, held);
    const auto& own = world.canvas.items.at(firstCloud(world));
    EXPECT_GT(lit->look.size, own.look.size);
    EXPECT_EQ(lit->look.views, own.look.views);
    world.session->setCamera([&] {
      OrbitCamera other = world.session->camera();
      other.yaw += 0.2;
      return other;
    }());
    world.click(car.first, car.second);
    lit = edge();
    if (lit == nullptr) continue;  // it has turned away
    const ViewCamera& camera = world.canvas.views().front().camera;
    for (const Vec3f& p : held) {
      const Projected at = camera.project(own.look.canvasFromItem * Vec3d(p));
      const Projected behind = camera.project(lit->look.canvasFromItem * Vec3d(p));
      if (at.depth < 1) continue;
      EXPECT_NEAR(at.x, behind.x, 1e-6);
      EXPECT_NEAR(at.y, behind.y, 1e-6);
      EXPECT_GT(behind.depth, at.depth);
    }
  }
}

TEST(SessionInstances, AMixtureOfClassesWarns) {
  auto frames = std::make_shared<FakeFrames>(1);
  Scan& scan = frames->frames[0].scans[0].scan;
  std::size_t cars = 0;
  for (const std::uint32_t id : scan[kInstance]) cars += id == 4711 ? 1 : 0;
  const std::size_t own = 3 * 72 + 70;
  const auto pickOwn = [&] {
    const SessionWorld world(frames);
    const auto [x, y] = world.pixelOf(firstCloud(world), own);
    return world.session->pick(x, y);
  };
  const auto pure = pickOwn();
  ASSERT_TRUE(pure);
  EXPECT_EQ(rowOf(*pure, "its points"), std::to_string(cars));
  EXPECT_EQ(rowOf(*pure, "its classes"), "");
  EXPECT_TRUE(pure->alarm.empty());
  for (std::size_t i = 0; i < 3; ++i) scan[kLabel][own - i] = kFakeTree;
  const auto mixed = pickOwn();
  ASSERT_TRUE(mixed);
  EXPECT_EQ(mixed->alarm, "its classes");
  EXPECT_EQ(rowOf(*mixed, mixed->alarm), "car " + std::to_string(cars - 3) + ", tree 3");
  EXPECT_LE(mixed->brief.size(), 5u);
}

// Each edge of a box is as long as a side of what is measured of the instance.
TEST(SessionInstances, HaveBoxesAboutTheirPoints) {
  SessionWorld world(3);
  const auto edges = [&] { return world.canvas.items.at(kBoxesItem).colors.size(); };
  EXPECT_EQ(edges(), 0u);
  world.key("O");
  EXPECT_EQ(edges(), 12u) << "the fake scan has one instance";
  const auto& item = world.canvas.items.at(kBoxesItem);
  EXPECT_EQ(item.colors.front(), kFakeCarColor);
  const Scan& scan = world.frames->frames[1].scans[0].scan;
  Box box;
  for (const Vec3f& p : item.places) box.add(Vec3d(p));
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan[kInstance][i] != 4711) continue;
    for (const double over :
         {scan.position[i].x - box.high.x, box.low.x - scan.position[i].x, scan.position[i].y - box.high.y,
          box.low.y - scan.position[i].y, scan.position[i].z - box.high.z, box.low.z - scan.position[i].z}) {
      EXPECT_LT(over, 1e-4);
    }
  }
  // They go with the points.
  const auto middle = [&] {
    Box all;
    for (const Vec3f& p : world.canvas.items.at(kBoxesItem).places) all.add(Vec3d(p));
    return all.center();
  };
  const auto points = [&] { return world.canvas.items.at(firstCloud(world)).look.canvasFromItem.translation; };
  const Vec3d before = middle() - points();
  world.key("w");
  EXPECT_GT(length(points()), 1);
  EXPECT_NEAR(length(middle() - points() - before), 0, 1e-4);
  world.key("O");
  EXPECT_EQ(edges(), 0u);
}

TEST(SessionBeam, JoinsItsReturns) {
  auto frames = std::make_shared<FakeFrames>(1);
  Scan& scan = frames->frames[0].scans[0].scan;
  scan[kReturn].assign(scan.size(), 0);
  scan.position.push_back(scan.position[3 * 72] * 2.0F);  // a second return behind one point
  visitTable(scan, [&](auto, auto& values) {
    if (!values.empty()) values.push_back(values[3 * 72]);
  });
  scan[kReturn].back() = 1;
  frames->frames[0].scans[0].error.clear();
  SessionWorld world(frames);
  const auto lines = [&] {
    const auto found = world.canvas.items.find(kBeamItem);
    return found == world.canvas.items.end() ? std::vector<Vec3f>{} : found->second.places;
  };
  EXPECT_TRUE(lines().empty());
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72);
  world.pointer(Kind::Move, x, y);
  world.session->drawWhenLoaded();
  ASSERT_EQ(lines().size(), 2u);
  EXPECT_EQ(lines()[0], scan.position[3 * 72]);
  EXPECT_EQ(lines()[1], scan.position.back());
  world.pointer(Kind::Move, 3, 60);
  world.session->drawWhenLoaded();
  EXPECT_TRUE(lines().empty());
}

constexpr std::size_t kEdges = 12;

// A car that is seen, with a front and a speed, and a tree that is not.
std::shared_ptr<FakeFrames> listedFrames() {
  auto frames = std::make_shared<FakeFrames>(2);
  ObjectRecord car;
  car.id = 4711;
  car.semantic = kFakeCar;
  car.name = "estate";
  car.moves = true;
  car.worldFromBox = {{}, {10, 90, 1}};
  car.size = {4, 2, 1.5};
  car.velocity = {3, 4, 0};
  ObjectView view;
  view.sensor = "top";
  view.sensorFromBox = {{}, {10, -10, -0.8}};
  view.points = view.beams = 30;
  view.beamsAlone = 60;
  car.views = {view};
  ObjectRecord tree;
  tree.id = 5;
  tree.semantic = kFakeTree;
  tree.headingKnown = false;
  tree.worldFromBox = {{}, {5, 110, 1}};
  tree.size = {1, 1, 3};
  frames->frames[0].objects = {car, tree};
  return frames;
}

const FakeCanvas::Item& boxes(const SessionWorld& world) {
  return world.canvas.items.at(kBoxesItem);
}

TEST(SessionBoxes, AreDrawnInTheColoursOfTheirClasses) {
  SessionWorld world(listedFrames(), {.sample = "0", .boxes = BoxChoice::All});
  const auto& colors = boxes(world).colors;
  ASSERT_EQ(colors.size(), kEdges + 1 + 1 + kEdges) << "two boxes, a front, and how far the car moves in a second";
  EXPECT_EQ(std::ranges::count(colors, kFakeCarColor), static_cast<long>(kEdges + 2));
  EXPECT_EQ(std::ranges::count(colors, kFakeTreeColor), 0) << "nothing is seen of it: it is faint";
  // The box lies where the points of its sensor lie: 10 m ahead and 10 m to the right of the sensor.
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
  frames->frames[0].objects[0].views[0].time = 0.55;
  frames->frames[0].objectTime = 0.5;
  const SessionWorld world(frames, {.sample = "0"});
  EXPECT_EQ(world.canvas.items.at(firstCloud(world)).places, scan.placed);
  Box car;
  for (std::size_t i = 0; i < 2 * kEdges; ++i) car.add(Vec3d(boxes(world).places[i]));
  EXPECT_NEAR(length(car.center() - Vec3d{10.15, -9.8, -0.8}), 0, 1e-5) << "as far as it moves in 0.05 s";
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72);
  const auto picked = world.session->pick(x, y);
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->position, Vec3d(scan.placed[picked->point]));
  EXPECT_EQ(rowOf(*picked, "x"), fmt::format("{:.3f} m", scan.scan.position[picked->point].x)) << "as the file has it";
}

// Views are of the sensor's first revolution.
TEST(SessionBoxes, FitPointsOfALaterRevolution) {
  const auto frames = listedFrames();
  ViewScan& scan = frames->frames[0].scans[0];
  scan.revolution = 1;
  scan.time = 0.6;
  frames->frames[0].objects[0].views[0].time = 0.55;
  frames->frames[0].objectTime = 0.5;
  const SessionWorld world(frames, {.sample = "0"});
  Box car;
  for (std::size_t i = 0; i < 2 * kEdges; ++i) car.add(Vec3d(boxes(world).places[i]));
  EXPECT_NEAR(length(car.center() - Vec3d{10.3, -9.6, -0.8}), 0, 1e-5) << "as far as it moves in 0.1 s";
}

TEST(SessionBoxes, FollowKeysAndFilters) {
  SessionWorld world(listedFrames(), {.sample = "0"});
  const auto drawn = [&] { return boxes(world).colors.size(); };
  EXPECT_EQ(drawn(), kEdges + 2) << "the car alone: a tree is no road user";
  world.key("O");
  EXPECT_EQ(drawn(), 2 * kEdges + 2) << "all";
  world.key("O");
  EXPECT_EQ(drawn(), 0u);
  world.key("O");
  EXPECT_EQ(drawn(), kEdges + 2);
  world.press("Right");
  EXPECT_EQ(drawn(), 0u) << "the next sample lists nothing";
  const SessionWorld cars(listedFrames(), {.sample = "0", .boxes = BoxChoice::All, .hidden = {"tree"}});
  EXPECT_EQ(boxes(cars).colors.size(), kEdges + 2);
  const SessionWorld alone(listedFrames(), {.sample = "0", .instances = {5}});
  EXPECT_EQ(boxes(alone).colors.size(), kEdges);
}

// The ego vehicle stands below its sensor as long as axes are on.
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
  const std::optional<PickedElement> picked = world.session->pick(x, y);
  ASSERT_TRUE(picked.has_value());
  EXPECT_EQ(rowOf(*picked, "object"), "estate");
  EXPECT_EQ(rowOf(*picked, "box"), "4.00 x 2.00 x 1.50 m");
  EXPECT_EQ(rowOf(*picked, "speed"), "5.00 m/s");
  EXPECT_EQ(rowOf(*picked, "visible"), "50 % (30 of 60 beams)");
}

}  // namespace
}  // namespace scanmill
