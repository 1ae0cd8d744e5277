// One instance among the points: shown alone, edged, measured, in a box; and the returns of one beam.

#include <set>

#include "tests/studio/viewer/window/session_world.h"
#include "viewer/window/session.h"
#include "viewer/window/session_items.h"

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
    world.session->settle();
    EXPECT_EQ(world.canvas.pointItems().size(), 1u);
    const auto edge = [&]() -> const FakeCanvas::Item* {
      world.pointer(Kind::Move, car.first, car.second);
      world.session->settle();
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
  world.session->settle();
  ASSERT_EQ(lines().size(), 2u);
  EXPECT_EQ(lines()[0], scan.position[3 * 72]);
  EXPECT_EQ(lines()[1], scan.position.back());
  world.pointer(Kind::Move, 3, 60);
  world.session->settle();
  EXPECT_TRUE(lines().empty());
}

}  // namespace
}  // namespace scanmill
