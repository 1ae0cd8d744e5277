// The viewer over scans whose beams have two returns, one or none.

#include "tests/core/sense/several_returns.h"

#include <set>

#include "tests/studio/viewer/window/session_world.h"
#include "viewer/window/picked_rows.h"

namespace scanmill {
namespace {

ViewScan viewOf(Scan scan, const std::string& name) {
  ViewScan view;
  view.name = name;
  view.scan = std::move(scan);
  return view;
}

std::size_t pointWith(const Scan& scan, const PointKey& key) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (keyOf(scan, i) == key && isFinite(scan.position[i])) return i;
  }
  throw std::runtime_error("no such point");
}

// Of 9 columns: beam 11 of ring 1, column 2 has two returns, beam 10 one, beam 9 none.
class ReturnRows : public testing::Test {
 protected:
  World world_ = makeSeveralReturns(4, 9);
  ViewScan dense_ = viewOf(senseOnce(world_, {}, {ColumnSet::all(), false}), "dense");
  ViewScan image_ = viewOf(senseOnce(world_, {}, {ColumnSet(kLabel), true}), "image");
};

TEST_F(ReturnRows, TellWhichOneItIs) {
  for (const ViewScan* view : {&dense_, &image_}) {
    for (const std::uint32_t number : {0u, 1u}) {
      const PickedThing thing = describePoint(*view, 0, pointWith(view->scan, {1, 2, number}), nullptr);
      EXPECT_EQ(rowOf(thing, "return"), std::to_string(number + 1)) << view->name;
      EXPECT_EQ(rowOf(thing, "ring"), "1");
      EXPECT_EQ(rowOf(thing, "column"), "2");
      EXPECT_EQ(rowOf(thing, "range"), number == 0 ? "10.000 m" : "15.000 m");
    }
  }
  EXPECT_EQ(rowOf(describePoint(dense_, 0, 0, nullptr), "cause"), "1");
}

TEST_F(ReturnRows, JoinByBeamAndReturn) {
  const auto ofOther = [](const ViewScan& own, const ViewScan& other, const PointKey& key) {
    PickedThing thing = describePoint(own, 0, pointWith(own.scan, key), nullptr);
    addSameBeam(thing, own.scan, other, nullptr);
    return rowOf(thing, other.name);
  };
  EXPECT_EQ(ofOther(dense_, image_, {1, 2, 0}), "10.00 m, class 1");
  EXPECT_EQ(ofOther(dense_, image_, {1, 2, 1}), "15.00 m, class 2");
  EXPECT_EQ(ofOther(image_, dense_, {1, 2, 1}), "15.00 m, class 2");
  EXPECT_EQ(ofOther(image_, dense_, {1, 1, 0}), "10.00 m, class 1");
  const ViewScan single = viewOf(senseOnce(makeWorld(4, 9, 12), {}, {ColumnSet(kRing, kColumn), false}), "single");
  EXPECT_EQ(ofOther(dense_, single, {1, 2, 0}), "12.00 m");
  EXPECT_EQ(ofOther(dense_, single, {1, 2, 1}), "no return");
}

class ReturnsSession : public testing::TestWithParam<bool> {};

// Every key and a click on every part of the range image, in both layouts.
TEST_P(ReturnsSession, ShowsAndPicks) {
  auto frames = std::make_shared<FakeFrames>(2, std::vector<std::string>{"ray_tracing", "depth_camera"});
  const World world = makeSeveralReturns(8, 72);
  for (ViewFrame& frame : frames->frames) {
    for (ViewScan& view : frame.scans) {
      view.scan = senseOnce(world, {"intensity: {}"}, {ColumnSet::all(), GetParam()});
      view.error.assign(view.scan.size(), 0.01F);
    }
  }
  const Scan& scan = frames->frames[0].scans[0].scan;
  SessionWorld shown(frames, {.rangeImage = true});
  for (const char key : std::string("1234567890vnv8")) {
    shown.key(std::string(1, key));
    EXPECT_GT(shown.session->picture().pixels.size(), 0u);
  }
  const auto& cloud = shown.canvas.items.at(firstCloud(shown));
  std::set<Rgb> colors;
  for (std::size_t i = 0; i < cloud.places.size(); ++i) {
    if (isFinite(cloud.places[i])) colors.insert(cloud.colors.at(i));
  }
  EXPECT_EQ(colors.size(), 2u) << "first returns and second ones";

  const PixelRect& view = shown.canvas.views().front().rect;
  std::set<std::pair<std::uint32_t, std::uint32_t>> beams;
  for (int y = view.top + view.height; y < SessionWorld::kHeight; y += 5) {
    for (int x = 2; x < SessionWorld::kWidth; x += 13) {
      const OrbitCamera before = shown.session->camera();
      shown.click(x, y);
      if (shown.session->camera() == before) continue;
      for (std::size_t i = 0; i < scan.size(); ++i) {
        if (Vec3d(scan.position[i]) != shown.session->camera().target) continue;
        EXPECT_EQ(keyOf(scan, i).number, 0u) << "the nearest return stands in front";
        beams.emplace(keyOf(scan, i).ring, keyOf(scan, i).column);
      }
    }
  }
  EXPECT_GT(beams.size(), 100u);
}

INSTANTIATE_TEST_SUITE_P(, ReturnsSession, testing::Bool(),
                         [](const auto& layout) { return layout.param ? "Organised" : "Dense"; });

}  // namespace
}  // namespace scanmill
