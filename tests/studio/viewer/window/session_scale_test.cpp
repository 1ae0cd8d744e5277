// Scales, legends, and frames that cannot be shown.

#include "tests/studio/viewer/window/session_world.h"
#include "viewer/color_map.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kThree{"ray_tracing", "depth_camera", "particle"};

std::vector<Rgb> colorsOn(const SessionWorld& world, std::size_t item = 0) {
  return world.canvas.items.at(world.canvas.pointItems()[item]).colors;
}

// The colours that a scale by the square root gives to ranges.
std::vector<Rgb> rangeColors(const Scan& scan, double low, double high) {
  std::vector<Rgb> colors;
  for (const Vec3f& p : scan.position) {
    const double share = std::clamp((length(Vec3d(p)) - low) / (high - low), 0.0, 1.0);
    colors.push_back(viridis(std::sqrt(share)));
  }
  return colors;
}

std::size_t countInOverlay(const SessionWorld& world, const Rgb& color) {
  std::size_t found = 0;
  for (const Rgba& o : world.canvas.overlay()) found += o[3] == 255 && Rgb{o[0], o[1], o[2]} == color ? 1 : 0;
  return found;
}

TEST(SessionScale, StaysOverFramesUntilTheColoursChange) {
  const ViewOptions options{.colors = {ColorBy("range")}, .scale = ScaleRange{2, 10}};
  SessionWorld world(3, {"ray_tracing"}, options);
  const auto& frames = world.frames->frames;
  EXPECT_EQ(colorsOn(world), rangeColors(frames[1].scans[0].scan, 2, 10));
  world.press("Right");
  EXPECT_EQ(colorsOn(world), rangeColors(frames[2].scans[0].scan, 2, 10));
  const auto held = colorsOn(world);
  world.key("\\");
  const auto automatic = colorsOn(world);
  EXPECT_NE(automatic, held);
  SessionWorld other(3, {"ray_tracing"}, options);
  for (const char* key : {"Right", "5", "4"}) other.press(key);
  EXPECT_EQ(colorsOn(other), automatic) << "other colours let go of it";
  SessionWorld classes(3, {"ray_tracing"}, {.colors = {kByClass}});
  const std::string before = classes.drawn();
  classes.key("\\");
  EXPECT_TRUE(classes.drawn() != before) << "it is said that they have no scale";
}

TEST(SessionScale, IsCommonToScansSideBySide) {
  SessionWorld world(1, kThree,
                     {.colors = {ColorBy("range"), ColorBy("range"), ColorBy("range")}, .layout = ViewLayout::Split});
  const auto& scans = world.frames->frames[0].scans;
  const auto low = colorScan(scans[0].scan, ColorBy("range"), {}).legend.low;
  const auto high = colorScan(scans[2].scan, ColorBy("range"), {}).legend.high;
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(colorsOn(world, k), rangeColors(scans[k].scan, low, high));
}

TEST(SessionScale, TellsPointsWithoutAValue) {
  auto frames = std::make_shared<FakeFrames>(1);
  ViewScan& scan = frames->frames[0].scans[0];
  scan.whyNoError = "no partner in the reference";
  SessionWorld known(frames, {.colors = {ColorBy("error")}});
  EXPECT_EQ(countInOverlay(known, kNoValue), 0u);
  for (std::size_t i = 0; i < 7; ++i) scan.error[i] = NAN;
  const Legend legend =
      colorScan(scan.scan, ColorBy("error"), ColorContext{.error = scan.error, .whyNoError = scan.whyNoError}).legend;
  EXPECT_EQ(legend.unknown, 7u);
  EXPECT_EQ(legend.whyUnknown, "no partner in the reference");
  SessionWorld world(frames, {.colors = {ColorBy("error")}});
  EXPECT_GT(countInOverlay(world, kNoValue), 40u);
}

// Rows stand still although a class comes and goes.
TEST(SessionLegend, KeepsTheClassesOfOtherFrames) {
  auto frames = std::make_shared<FakeFrames>(3);
  for (std::uint16_t& label : frames->frames[1].scans[0].scan[kLabel]) {
    if (label == kFakeTree) label = kFakeRoad;
  }
  SessionWorld world(frames, {.sample = "0"});
  const auto car = world.inOverlay(kFakeCarColor);
  ASSERT_TRUE(world.inOverlay(kFakeTreeColor));
  world.press("Right");
  EXPECT_EQ(world.inOverlay(kFakeCarColor), car);
  EXPECT_TRUE(world.inOverlay(kFakeTreeColor));
}

TEST(SessionLegend, IsDrawnOnceWhereAllViewsMeanTheSame) {
  SessionWorld world(1, kThree, {.layout = ViewLayout::Split});
  const std::size_t once = countInOverlay(world, kFakeCarColor);
  EXPECT_GT(once, 40u);
  EXPECT_LT(once, 200u);
  const auto at = world.inOverlay(kFakeCarColor);
  ASSERT_TRUE(at);
  EXPECT_GT(at->first, world.canvas.views().back().rect.left) << "beside the views";
  const std::size_t before = world.canvas.shownOf(world.canvas.pointItems()[0]).size();
  world.click(at->first, at->second);
  for (const ItemId item : world.canvas.pointItems()) EXPECT_LT(world.canvas.shownOf(item).size(), before);
  // Where one differs, the others still have theirs in common.
  world.click(at->first, at->second);
  const std::string classes = world.drawn();
  world.key("Tab");
  world.key("4");
  EXPECT_EQ(countInOverlay(world, kFakeCarColor), once);
  EXPECT_NE(world.drawn(), classes);
}

TEST(SessionDamage, WhereNoFrameCanBeReadTheReasonIsSaid) {
  auto frames = std::make_shared<FakeFrames>(4);
  for (ViewFrame& frame : frames->frames) {
    frame.scans.clear();
    frame.problems = {"train-000000.tar: is damaged"};
  }
  SessionWorld world(frames);
  EXPECT_THAT(world.session->problems(), ElementsAre("train-000000.tar: is damaged"));
  EXPECT_THROW(world.session->check(), Error);
  const PixelRect rect = world.canvas.views().front().rect;
  int written = 0;
  for (int x = rect.left + 100; x < rect.left + rect.width - 100; ++x) {
    written += world.canvas.overlayAt(x, rect.top + rect.height / 2)[3] > 0 ? 1 : 0;
  }
  EXPECT_GT(written, 100) << "in the middle";
}

TEST(SessionDamage, AFilterThatHidesAllSaysSo) {
  SessionWorld world(1, {"ray_tracing"}, {.hidden = {"road", "tree", "car"}});
  EXPECT_TRUE(world.canvas.shownOf(firstCloud(world)).empty());
  const auto middle = [&] {
    const PixelRect rect = world.canvas.views().front().rect;
    return world.canvas.overlayAt(rect.left + rect.width / 2, rect.top + rect.height / 2)[3];
  };
  EXPECT_GT(middle(), 0);
  world.key("A");
  EXPECT_EQ(middle(), 0);
}

TEST(SessionHints, ClassesWithoutNamesAreSaidOnce) {
  auto frames = std::make_shared<FakeFrames>(3);
  frames->named = false;
  SessionWorld world(frames);
  world.press("Right");
  EXPECT_THAT(world.session->hints(), ElementsAre(HasSubstr("--ontology")));
}

}  // namespace
}  // namespace scanmill
