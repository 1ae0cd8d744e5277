// Colours and range images of scans whose beams have two returns, one or none.

#include "tests/core/sense/several_returns.h"

#include "viewer/color_map.h"
#include "viewer/coloring.h"
#include "viewer/picture.h"
#include "viewer/range_strip.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kRings = 16;
constexpr std::uint32_t kColumns = 60;
constexpr std::uint32_t kBeams = kRings * kColumns;  // a third of them has two returns, a third one

// Dense and organised; with the column `return` and, where the order tells it, without.
std::vector<Scan> layouts() {
  const World world = makeSeveralReturns(kRings, kColumns);
  std::vector<Scan> scans;
  scans.push_back(senseOnce(world, {"intensity: {}"}, {ColumnSet::all(), false}));
  scans.push_back(senseOnce(world, {"intensity: {}"}, {ColumnSet::all(), true}));
  scans.push_back(senseOnce(world, {"intensity: {}"}, {ColumnSet::all().without(kReturn), true}));
  return scans;
}

TEST(SeveralReturnsColors, TellTheReturn) {
  for (const Scan& scan : layouts()) {
    EXPECT_TRUE(hasColor(scan, kByReturn, false));
    const Coloring coloring = colorScan(scan, kByReturn, {});
    ASSERT_EQ(coloring.colors.size(), scan.size());
    const std::vector<LegendEntry>& entries = coloring.legend.entries;
    ASSERT_EQ(entries.size(), 2u);
    EXPECT_EQ(entries[0].name, "return 1");
    EXPECT_EQ(entries[1].name, "return 2");
    EXPECT_EQ(entries[0].points, 2 * kBeams / 3);
    EXPECT_EQ(entries[1].points, kBeams / 3);
    EXPECT_NE(entries[0].color, entries[1].color);
    EXPECT_FALSE(coloring.legend.scale);
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (isFinite(scan.position[i])) {
        EXPECT_EQ(coloring.colors[i], entries[keyOf(scan, i).number].color);
      }
    }
  }
}

TEST(SeveralReturnsColors, OfEveryKindAreThere) {
  for (const Scan& scan : layouts()) {
    for (const ColorBy& by : colorsOf(scan)) {
      if (!hasColor(scan, by, false)) continue;
      EXPECT_EQ(colorScan(scan, by, {}).colors.size(), scan.size()) << by.name();
    }
  }
}

// Each beam has a pixel, which shows its nearest return; that of its other returns is the same.
TEST(SeveralReturnsStrip, ShowsTheNearest) {
  for (const Scan& scan : layouts()) {
    const Coloring coloring = colorScan(scan, kByReturn, {});
    const RangeStrip strip = makeRangeStrip(scan, coloring.colors, {});
    EXPECT_TRUE(strip.outward);
    EXPECT_EQ(strip.image.width, static_cast<int>(kColumns));
    EXPECT_EQ(strip.image.height, static_cast<int>(kRings));
    ASSERT_EQ(strip.pixelOf.size(), scan.size());
    std::size_t shown = 0;
    for (const std::uint32_t point : strip.pointAt) {
      if (point == kNoPoint) continue;
      ++shown;
      EXPECT_EQ(keyOf(scan, point).number, 0u);
    }
    EXPECT_EQ(shown, 2 * kBeams / 3);
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (!isFinite(scan.position[i])) continue;
      const std::uint32_t front = strip.pointAt[strip.pixelOf[i]];
      ASSERT_NE(front, kNoPoint);
      EXPECT_EQ(keyOf(scan, front).ring, keyOf(scan, i).ring);
      EXPECT_EQ(keyOf(scan, front).column, keyOf(scan, i).column);
    }
    // Hidden points do not cover the points behind them.
    std::vector<bool> further(scan.size());
    for (std::size_t i = 0; i < scan.size(); ++i) further[i] = keyOf(scan, i).number == 1;
    const RangeStrip behind = makeRangeStrip(scan, coloring.colors, further);
    EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(behind.pointAt, kNoPoint)),
              strip.pointAt.size() - kBeams / 3);
  }
}

TEST(SeveralReturnsPictures, AreDrawn) {
  for (const Scan& scan : layouts()) {
    const Coloring coloring = colorScan(scan, kByReturn, {});
    const Image picture = drawScan(scan, coloring, 320, 200, "two returns");
    const Rgb second = coloring.legend.entries.at(1).color;
    EXPECT_TRUE(std::ranges::find(picture.pixels, second) != picture.pixels.end());
    EXPECT_GT(drawRangeImage(scan, nullptr, kByReturn, "two returns").pixels.size(), kBeams);
  }
}

}  // namespace
}  // namespace scanmill
