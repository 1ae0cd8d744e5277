#include "viewer/range_strip.h"

#include "tests/support/message_of.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"

namespace scanmill {
namespace {

// Every beam of 8 rings x 30 columns meets something; ring 0 looks up unless `rising`.
Scan fullScan(bool rising) {
  Scan scan;
  scan.rings = 8;
  scan.columns = 30;
  for (std::uint16_t ring = 0; ring < 8; ++ring) {
    for (std::uint16_t column = 0; column < 30; ++column) {
      const double azimuth = 2 * M_PI * column / 30;
      const double elevation = (rising ? 1 : -1) * (ring - 3.5) * 0.05;
      scan.position.push_back(Vec3f(Vec3d{10 * std::cos(azimuth), 10 * std::sin(azimuth), 10 * std::tan(elevation)}));
      scan[kRing].push_back(ring);
      scan[kColumn].push_back(column);
    }
  }
  return scan;
}

std::vector<Rgb> colorEach(const Scan& scan) {
  std::vector<Rgb> colors;
  for (std::size_t i = 0; i < scan.size(); ++i) colors.push_back(instanceColor(static_cast<std::uint32_t>(i + 1)));
  return colors;
}

TEST(RangeStrip, PointsAndPixelsLeadToEachOther) {
  for (const bool rising : {false, true}) {
    const Scan scan = fullScan(rising);
    const std::vector<Rgb> colors = colorEach(scan);
    const RangeStrip strip = makeRangeStrip(scan, colors, {});
    ASSERT_EQ(strip.image.width, 30);
    ASSERT_EQ(strip.image.height, 8);
    EXPECT_EQ(strip.ringsRise, rising);
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto [column, row] = strip.place(i);
      EXPECT_EQ(row, rising ? 7 - scan[kRing][i] : scan[kRing][i]);
      EXPECT_EQ(strip.pointAt[strip.pixelOf[i]], i);
      EXPECT_EQ(strip.image.at(column, row), colors[i]);
    }
  }
}

TEST(RangeStrip, AnOrganisedScanIsTheSameStrip) {
  const Scan dense = fullScan(true);
  Scan organised = dense;
  organised.organised = true;
  organised[kRing].clear();
  organised[kColumn].clear();
  const std::vector<Rgb> colors = colorEach(dense);
  const RangeStrip a = makeRangeStrip(dense, colors, {});
  RangeStrip b = makeRangeStrip(organised, colors, {});
  EXPECT_EQ(a.image.pixels, b.image.pixels);
  EXPECT_EQ(a.pixelOf, b.pixelOf);
  organised.position[37] = {NAN, NAN, NAN};
  b = makeRangeStrip(organised, colors, {});
  EXPECT_EQ(b.pixelOf, a.pixelOf);
  EXPECT_EQ(b.pointAt[b.pixelOf[37]], kNoPoint);
  EXPECT_EQ(b.image.pixels[b.pixelOf[37]], kBackground);
}

TEST(RangeStrip, TheNearestThatIsShownWins) {
  Scan scan;
  scan.position = {{9, 0, 0}, {3, 0, 0}, {6, 0, 0}};
  scan[kRing] = scan[kColumn] = {0, 0, 0};
  const std::vector<Rgb> colors = colorEach(scan);
  EXPECT_EQ(makeRangeStrip(scan, colors, {}).pointAt, std::vector<std::uint32_t>{1});
  const RangeStrip second = makeRangeStrip(scan, colors, {true, false, true});
  EXPECT_EQ(second.pointAt, std::vector<std::uint32_t>{2});
  EXPECT_EQ(second.image.pixels[0], colors[2]);
  const RangeStrip none = makeRangeStrip(scan, colors, {false, false, false});
  EXPECT_EQ(none.pointAt, std::vector<std::uint32_t>{kNoPoint});
  EXPECT_EQ(none.image.pixels[0], kBackground);
  EXPECT_EQ(none.place(1), std::pair(0, 0)) << "where it would stand";
}

TEST(RangeStrip, SaysWhatIsMissing) {
  Scan scan = fullScan(true);
  const std::vector<Rgb> colors = colorEach(scan);
  scan[kColumn].clear();
  expectInputError([&] { makeRangeStrip(scan, colors, {}); }, {"'column'", "output.columns"});
  scan = fullScan(true);
  scan[kRing].clear();
  expectInputError([&] { makeRangeStrip(scan, colors, {}); }, {"'ring'"});
  scan = fullScan(true);
  scan[kColumn][3] = 65535;
  expectInputError([&] { makeRangeStrip(scan, colors, {}); }, {"65536"});
  EXPECT_NO_THROW(makeRangeStrip({}, {}, {}));
}

}  // namespace
}  // namespace scanmill
