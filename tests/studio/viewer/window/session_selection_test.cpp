// Points that are chosen by a box or a lasso, instances, and the returns of a beam.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "dataset/scan_source.h"
#include "tests/studio/viewer/window/session_world.h"
#include "tests/support/temporary_folder.h"
#include "viewer/window/session_items.h"

namespace scanmill {
namespace {

using Kind = CanvasEvent::Kind;

std::set<std::uint32_t> within(const SessionWorld& world, int left, int top, int right, int bottom) {
  std::set<std::uint32_t> points;
  const auto& item = world.canvas.items.at(firstCloud(world));
  const CanvasView& view = world.canvas.views().front();
  for (const std::uint32_t i : world.canvas.shownOf(firstCloud(world))) {
    const Projected p = view.camera.project(item.look.canvasFromItem * Vec3d(item.places[i]));
    const double x = view.rect.left + p.x;
    const double y = view.rect.top + p.y;
    if (p.depth >= view.camera.nearest && x > left && x < right && y > top && y < bottom) points.insert(i);
  }
  return points;
}

// Those that are marked are places of the scan.
std::set<std::uint32_t> marked(const SessionWorld& world) {
  std::set<std::uint32_t> points;
  const auto found = world.canvas.items.find(kSelectedItem);
  if (found == world.canvas.items.end()) return points;
  const auto& all = world.canvas.items.at(firstCloud(world)).places;
  for (const Vec3f& p : found->second.places) {
    points.insert(static_cast<std::uint32_t>(std::ranges::find(all, p) - all.begin()));
  }
  return points;
}

TEST(SessionSelection, ABoxTakesWhatIsSeenInIt) {
  SessionWorld world(2, {"ray_tracing"}, {.hidden = {"tree"}});
  const OrbitCamera before = world.session->camera();
  world.key("u");
  world.drag(200, 200, 300, 250);
  EXPECT_EQ(world.session->camera(), before) << "the drag turned nothing";
  const auto expected = within(world, 200, 200, 500, 450);
  EXPECT_GT(expected.size(), 20u);
  EXPECT_EQ(marked(world), expected);
  world.drag(300, 300, 40, 0);
  EXPECT_FALSE(world.session->camera() == before) << "one selection, one drag";
  EXPECT_EQ(marked(world), expected) << "they stay selected";
  world.key("Escape");
  EXPECT_TRUE(marked(world).empty());
}

// A lasso around a rectangle is that rectangle, whichever way round.
TEST(SessionSelection, ALassoTakesWhatIsInsideOfIt) {
  for (const bool clockwise : {true, false}) {
    SessionWorld world(1);
    world.key("U");
    world.pointer(Kind::Down, 200, 200);
    const auto along = [&](int x0, int y0, int x1, int y1) {
      for (int i = 1; i <= 25; ++i) world.pointer(Kind::Move, x0 + (x1 - x0) * i / 25, y0 + (y1 - y0) * i / 25);
    };
    if (clockwise) {
      along(200, 200, 500, 200);
      along(500, 200, 500, 450);
      along(500, 450, 200, 450);
    } else {
      along(200, 200, 200, 450);
      along(200, 450, 500, 450);
      along(500, 450, 500, 200);
    }
    world.pointer(Kind::Up, clockwise ? 200 : 500, clockwise ? 450 : 200);
    world.session->settle();
    EXPECT_EQ(marked(world), within(world, 200, 200, 500, 450)) << clockwise;
  }
}

TEST(SessionSelection, OfNothingSaysSoAndFramesLetGoOfIt) {
  SessionWorld world(3);
  world.key("u");
  world.drag(200, 60, 3, 2);
  EXPECT_TRUE(marked(world).empty());
  world.key("u");
  world.drag(200, 200, 300, 250);
  EXPECT_FALSE(marked(world).empty());
  world.key("Right");
  world.session->settle();
  EXPECT_TRUE(marked(world).empty());
}

// The file holds the points that are marked, with their columns.
TEST(SessionSelection, IsSavedAsPcd) {
  const TemporaryFolder folder;
  const std::filesystem::path back = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  SessionWorld world(1);
  world.key("u");
  world.drag(200, 200, 300, 250);
  world.session->settle();
  const auto selected = marked(world);
  // The button stands somewhere in the side: pressing all over it saves at least once.
  for (int y = 30; y < 200 && !std::filesystem::exists("scanmill_selection_000.pcd"); y += 6) {
    world.click(SessionWorld::kWidth - 230, y);
  }
  std::filesystem::current_path(back);
  const std::filesystem::path file = folder.path() / "scanmill_selection_000.pcd";
  ASSERT_TRUE(std::filesystem::exists(file));
  const Scan saved = findScan(file, "", "").scan;
  const Scan& whole = world.frames->frames[0].scans[0].scan;
  ASSERT_EQ(saved.size(), selected.size());
  std::set<std::uint32_t> found;
  for (std::size_t k = 0; k < saved.size(); ++k) {
    const std::uint32_t i = saved[kRing][k] * 72U + saved[kColumn][k];
    EXPECT_EQ(saved.position[k], whole.position[i]);
    EXPECT_EQ(saved[kLabel][k], whole[kLabel][i]);
    found.insert(i);
  }
  EXPECT_EQ(found, selected);
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
