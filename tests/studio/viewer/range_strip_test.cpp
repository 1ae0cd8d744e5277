#include "viewer/range_strip.h"

#include <set>

#include "base/random.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "viewer/color_map.h"
#include "viewer/frames/frame_source.h"
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
      const auto [column, row] = strip.pixelPosition(i);
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
  EXPECT_EQ(none.pixelPosition(1), std::pair(0, 0)) << "where it would stand";
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

struct Turning {
  bool clockwise = false;
  double field = 2 * kPi;
  double first = 0;    // rad
  double offset = 0;   // rad, of the rings, which take turns
  bool known = false;  // by the beam table
};

BeamTable tableOf(const Turning& turning) {
  BeamTable table;
  table.rings = 8;
  table.columns = 120;
  table.clockwise = turning.clockwise;
  table.field = turning.field;
  table.firstAzimuth = turning.first;
  table.period = 0.1;
  for (std::uint32_t ring = 0; ring < table.rings; ++ring) {
    table.elevation.push_back(0.05 * (ring - 3.5));
    table.azimuthOffset.push_back(turning.offset * (ring % 4 - 1.5) / 1.5);
    table.firingOffset.push_back(0);
  }
  fillBeams(table);
  return table;
}

// Walls at all distances; every 7th beam misses.
Scan scanOf(const BeamTable& table) {
  Scan scan;
  scan.rings = table.rings;
  scan.columns = table.columns;
  for (std::uint32_t beam = 0; beam < table.size(); ++beam) {
    const RandomBlock random = randomBlock({.beam = beam});
    if (random[0] % 7 == 0) continue;
    scan.position.push_back(Vec3f(table.direction[beam] * (2 + 60 * uniform(random[1]))));
    scan[kRing].push_back(static_cast<std::uint16_t>(beam / table.columns));
    scan[kColumn].push_back(static_cast<std::uint16_t>(beam % table.columns));
  }
  return scan;
}

RangeStrip stripOf(const Scan& scan, const BeamTable* beams) {
  return makeRangeStrip(scan, std::vector<Rgb>(scan.size(), Rgb{255, 255, 255}), {}, beams);
}

double azimuthOf(const Vec3f& p) {
  return std::atan2(p.y, p.x);
}

std::vector<Turning> allTurnings() {
  std::vector<Turning> all;
  for (const bool clockwise : {false, true}) {
    for (const double first : {0.0, 1.234, -3.1}) {
      for (const double offset : {0.0, 0.055}) {
        for (const bool known : {false, true}) {
          all.push_back({clockwise, 2 * kPi, first, offset, known});
          for (const double field : {120, 270}) all.push_back({clockwise, radians(field), first, offset, known});
        }
      }
    }
  }
  return all;
}

TEST(BeamAzimuths, EveryPointKeepsItsOwnPixel) {
  for (const Turning& turning : allTurnings()) {
    const BeamTable table = tableOf(turning);
    const Scan scan = scanOf(table);
    const RangeStrip strip = stripOf(scan, turning.known ? &table : nullptr);
    ASSERT_TRUE(strip.outward);
    const bool full = table.fullTurn();
    EXPECT_EQ(strip.fullTurn, full);
    EXPECT_EQ(strip.columns, 120u);
    EXPECT_EQ(strip.image.width == 120, full || turning.offset == 0 || !turning.known) << strip.image.width;
    EXPECT_LE(strip.image.width, 128);
    std::set<std::uint32_t> pixels;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      ASSERT_LT(strip.pixelOf[i], strip.pointAt.size());
      ASSERT_EQ(strip.pointAt[strip.pixelOf[i]], i);
      pixels.insert(strip.pixelOf[i]);
      ASSERT_EQ(strip.pixelPosition(i).second, strip.ringsRise ? 7 - scan[kRing][i] : scan[kRing][i]);
    }
    EXPECT_EQ(pixels.size(), scan.size());
    EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(strip.pointAt, kNoPoint)),
              strip.pointAt.size() - scan.size());
  }
}

// A pixel's azimuth is known by its column alone, whatever the ring: half a column may be lost where rings are shifted,
// half a one where straight ahead is between two columns, and half a one more where the offsets are estimated.
TEST(BeamAzimuths, PixelColumnsAreAzimuths) {
  for (const Turning& turning : allTurnings()) {
    const BeamTable table = tableOf(turning);
    const Scan scan = scanOf(table);
    const RangeStrip strip = stripOf(scan, turning.known ? &table : nullptr);
    const bool full = table.fullTurn();
    if (!full && !turning.known && turning.offset != 0) continue;  // the rings are not shifted
    const double step = table.field / (full ? 120 : 119);
    double middle = 0;
    if (!full) middle = turning.first + (turning.clockwise ? -0.5 : 0.5) * turning.field;
    const double center = full ? 60 : (strip.image.width - 1) / 2.0;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const double left = std::remainder(azimuthOf(scan.position[i]) - middle, 2 * kPi) / step;
      const double found = center - strip.pixelPosition(i).first;
      ASSERT_LE(std::abs(full ? std::remainder(found - left, 120) : found - left), full && turning.known ? 1.02 : 1.52)
          << turning.first << ' ' << turning.offset << ' ' << turning.clockwise << turning.known;
    }
  }
}

// Hits in a narrow sector show the same as hits all around, whether or not the beams are known, one by one.
TEST(BeamAzimuths, AFewHitsAreOnTheirSide) {
  for (const double field : {120, 270, 360}) {
    for (const bool clockwise : {false, true}) {
      BeamTable table = tableOf({clockwise, radians(field), radians(clockwise ? field / 2 : -field / 2)});
      Scan scan = scanOf(table);
      for (Vec3f& p : scan.position) {
        if (std::abs(azimuthOf(p) - radians(40)) > radians(10)) p = {NAN, NAN, NAN};
      }
      auto listed = std::make_shared<ListedBeams>();
      for (const Vec3d& d : table.direction) {
        listed->azimuth.push_back(std::atan2(d.y, d.x));
        listed->elevation.push_back(std::asin(d.z));
        listed->time.push_back(0);
      }
      BeamTable one = table;
      one.pattern = listed;
      for (const BeamTable* beams : {static_cast<const BeamTable*>(nullptr), &std::as_const(one)}) {
        const RangeStrip strip = stripOf(scan, beams);
        ASSERT_TRUE(strip.outward);
        EXPECT_EQ(strip.fullTurn, field == 360);
        for (std::size_t i = 0; i < scan.size(); ++i) {
          if (!isFinite(scan.position[i])) continue;
          const double expected = 60 - azimuthOf(scan.position[i]) / radians(field) * 120;
          ASSERT_NEAR(strip.pixelPosition(i).first, expected, 2) << field << clockwise;
        }
      }
    }
  }
}

TEST(BeamAzimuths, ColumnsOfNoAzimuthStayAsTheyAre) {
  Scan scan = scanOf(tableOf({}));
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const RandomBlock random = randomBlock({.frame = 3, .beam = static_cast<std::uint32_t>(i)});
    const double azimuth = 6 * uniform(random[0]);
    scan.position[i] = Vec3f(Vec3d{5 * std::cos(azimuth), 5 * std::sin(azimuth), 0});
  }
  const RangeStrip strip = stripOf(scan, nullptr);
  EXPECT_FALSE(strip.outward);
  EXPECT_NE(describeStrip(strip).find("do not follow the azimuth"), std::string::npos);
  for (std::size_t i = 0; i < scan.size(); ++i) ASSERT_EQ(strip.pixelPosition(i).first, scan[kColumn][i]);
  Scan one;
  one.position = {{5, 0, 0}};
  one[kRing] = one[kColumn] = {0};
  EXPECT_FALSE(stripOf(one, nullptr).outward);
  EXPECT_FALSE(stripOf({}, nullptr).outward);
}

// Columns of an image are not evenly apart in azimuth, and rows do not keep their elevation.
TEST(BeamAzimuths, AnImageStaysAnImage) {
  for (const double side : {1.0, -1.0}) {
    Scan scan;
    scan.rings = 20;
    scan.columns = 100;
    BeamTable table;
    table.rings = scan.rings;
    table.columns = scan.columns;
    auto listed = std::make_shared<ListedBeams>();
    for (std::uint32_t beam = 0; beam < table.size(); ++beam) {
      const double left = 2.5 * side * ((beam % 100) - 49.5) / 50;
      const Vec3d towards = normalized(Vec3d{1, left, 0.3 - 0.03 * (beam / 100)});
      listed->azimuth.push_back(std::atan2(towards.y, towards.x));
      listed->elevation.push_back(std::asin(towards.z));
      listed->time.push_back(0);
      scan.position.push_back(Vec3f(towards * (5 + uniform(randomBlock({.beam = beam})[0]))));
      scan[kRing].push_back(static_cast<std::uint16_t>(beam / 100));
      scan[kColumn].push_back(static_cast<std::uint16_t>(beam % 100));
    }
    table.pattern = listed;
    fillBeams(table);
    for (const BeamTable* beams : {static_cast<const BeamTable*>(nullptr), static_cast<const BeamTable*>(&table)}) {
      const RangeStrip strip = stripOf(scan, beams);
      EXPECT_TRUE(strip.outward);
      EXPECT_EQ(strip.image.width, 100);
      for (std::size_t i = 0; i < scan.size(); ++i) {
        const int column = scan[kColumn][i];
        ASSERT_EQ(strip.pixelPosition(i).first, side < 0 ? column : 99 - column);  // left is left
      }
    }
  }
}

TEST(BeamAzimuths, ARealSensorsColumnsAreWhereItsPointsAre) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128/frame_1795.pcd");
  const auto source = openFrames({.path = sharedData() / "lidar/ouster_os1_128/frame_1795.pcd"});
  const Scan scan = source->load(0).scans.at(0).scan;
  const RangeStrip outward = stripOf(scan, nullptr);
  ASSERT_TRUE(outward.outward);
  EXPECT_TRUE(outward.fullTurn);
  ASSERT_EQ(outward.image.width, 1024);
  double strayed = 0;
  double count = 0;
  const double step = 2 * kPi / outward.image.width;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    ASSERT_EQ(outward.pointAt[outward.pixelOf[i]], i);
    const double left = azimuthOf(scan.position[i]) / step;
    const double found = outward.image.width / 2 - outward.pixelPosition(i).first;
    strayed += std::abs(std::remainder(found - left, outward.image.width)) > 1.5 ? 1 : 0;
    count += 1;
  }
  EXPECT_LT(strayed, 0.1 * count);
}

}  // namespace
}  // namespace scanmill
