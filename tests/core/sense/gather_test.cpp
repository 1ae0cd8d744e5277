#include <map>
#include <tuple>

#include "sense/sense.h"
#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

constexpr ScanLayout kDense{ColumnSet::all(), false};
constexpr ScanLayout kOrganised{ColumnSet::all(), true};

using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;

std::map<Key, std::size_t> pointsByKey(const Scan& scan) {
  std::map<Key, std::size_t> points;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    const PointKey key = keyOf(scan, i);
    EXPECT_TRUE(points.emplace(Key{key.ring, key.column, key.number}, i).second) << "a key is of one point";
  }
  return points;
}

TEST(Gather, ABeamHasAsManyPointsAsReturns) {
  for (const auto& [rings, columns] :
       std::vector<std::pair<std::uint32_t, std::uint32_t>>{{1, 1}, {3, 11}, {17, 65}, {40, 130}}) {
    const World world = makeSeveralReturns(rings, columns);
    const Scan scan = senseOnce(world, {"intensity: {}"}, kDense);
    std::size_t k = 0;
    for (std::uint32_t c = 0; c < columns; ++c) {
      for (std::uint32_t r = 0; r < rings; ++r) {
        const std::uint32_t beam = r * columns + c;
        for (std::uint32_t number = 0; number < beam % 3; ++number, ++k) {
          ASSERT_LT(k, scan.size());
          ASSERT_EQ(scan[kRing][k], r);
          ASSERT_EQ(scan[kColumn][k], c);
          ASSERT_EQ(scan[kReturn][k], number + 1);
          ASSERT_EQ(scan[kLabel][k], number + 1);
          ASSERT_EQ(scan[kInstance][k], 100 + beam);
          ASSERT_EQ(scan[kTime][k], world.shot.beams->time[beam]);
          ASSERT_EQ(scan[kRangeTrue][k], number == 0 ? 10 : 15);
          ASSERT_EQ(scan[kCause][k], static_cast<std::uint8_t>(Reason::Surface));
          // A white wall at the reference range has the power 1, and two rays have half of it each.
          const double share = beam % 3 == 2 ? 0.5 : 1;
          ASSERT_NEAR(scan[kIntensity][k], share * (number == 0 ? 1 : 100.0 / 225), 1e-6);
          const Vec3d expected = world.shot.beams->direction[beam] * double{scan[kRangeTrue][k]};
          ASSERT_EQ(scan.position[k], static_cast<Vec3f>(expected));
        }
      }
    }
    EXPECT_EQ(k, scan.size());
    EXPECT_EQ(scan.planes, 1u);
  }
}

TEST(Gather, AScanWithoutPointsHasItsColumns) {
  const ColumnSet columns(kIntensity, kLabel, kRing);
  const Scan scan = senseOnce(makeSeveralReturns(1, 1), {"intensity: {}"}, {columns, false});
  EXPECT_EQ(scan.size(), 0u);
  EXPECT_EQ(columnsOf(scan), columns);
}

TEST(Gather, FurtherReturnsAreFurtherPlanes) {
  const World world = makeSeveralReturns(17, 65);
  const Scan dense = senseOnce(world, {"intensity: {}", "range_noise: {sigma_m: 0.02}"}, kDense);
  const Scan organised = senseOnce(world, {"intensity: {}", "range_noise: {sigma_m: 0.02}"}, kOrganised);
  EXPECT_EQ(organised.planes, 2u);
  EXPECT_EQ(organised.width(), 65u);
  EXPECT_EQ(organised.height(), 34u);
  ASSERT_EQ(organised.size(), 2u * 17u * 65u);
  const auto points = pointsByKey(dense);
  std::size_t found = 0;
  for (std::size_t i = 0; i < organised.size(); ++i) {
    const PointKey key = keyOf(organised, i);
    EXPECT_EQ(i, (std::size_t{key.number} * 17 + key.ring) * 65 + key.column);
    const auto twin = points.find({key.ring, key.column, key.number});
    ASSERT_EQ(twin != points.end(), isFinite(organised.position[i]));
    if (twin == points.end()) continue;
    ++found;
    EXPECT_EQ(organised.position[i], dense.position[twin->second]);
    visitTable(organised, [&](auto column, const auto& values) { EXPECT_EQ(values[i], dense[column][twin->second]); });
  }
  EXPECT_EQ(found, dense.size());
}

// Where every beam has one ray, a table with indices gives the same scan as one without.
TEST(Gather, IndicesChangeNothing) {
  const World plain = makeRaggedWorld(33, 130);
  World indexed = plain;
  for (std::uint32_t ray = 0; ray < plain.hits.rays(); ++ray) indexed.hits.beamOfRay.push_back(ray);
  for (const ScanLayout& layout : {kDense, kOrganised}) {
    const Scan a = senseOnce(plain, kManyEffects, layout);
    const Scan b = senseOnce(indexed, kManyEffects, layout);
    ASSERT_EQ(a.size(), b.size());
    const auto same = [](const auto& x, const auto& y) { return x == y || (x != x && y != y); };
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_TRUE(a.position[i] == b.position[i] || (!isFinite(a.position[i]) && !isFinite(b.position[i])));
    }
    visitTable(a, [&](auto key, const auto& values) {
      EXPECT_TRUE(std::equal(values.begin(), values.end(), b[key].begin(), b[key].end(), same)) << key.row.name;
    });
  }
}

// Azimuth, elevation and distance from the sensor's origin give the noise-free point again, whatever the noise, and
// wherever beams start.
TEST(Gather, AnglesAreThoseOfTheNoiseFreePoint) {
  constexpr auto kAzimuth = ColumnKey<columnIndex("azimuth")>{};
  constexpr auto kElevation = ColumnKey<columnIndex("elevation")>{};
  for (World world : {makeRaggedWorld(16, 90), makeSeveralReturns(16, 90, 3)}) {
    for (const Vec3f& origin : {Vec3f{}, Vec3f{0.3f, -0.2f, 0.1f}}) {
      world.beams().origin.assign(world.hits.size(), origin);
      const Scan exact = senseOnce(world, {}, kDense);
      const Scan noisy = senseOnce(world, {"range_noise: {sigma_m: 0.1}", "angular_jitter: {sigma_deg: 1}"}, kDense);
      ASSERT_EQ(noisy[kAzimuth].size(), exact.size());
      EXPECT_EQ(noisy[kAzimuth], exact[kAzimuth]);
      EXPECT_EQ(noisy[kElevation], exact[kElevation]);
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const double azimuth = exact[kAzimuth][i];
        const double elevation = exact[kElevation][i];
        const Vec3d direction{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation)};
        const Vec3d point(exact.position[i]);
        EXPECT_NEAR(length(direction * length(point) - point), 0, 1e-6 * length(point));
      }
    }
  }
  World misses = makeWorld(2, 3);
  miss(misses, 4);
  const Scan organised = senseOnce(misses, {}, kOrganised);
  EXPECT_TRUE(std::isnan(organised[kAzimuth][4]) && std::isnan(organised[kElevation][4]));
  EXPECT_FALSE(std::isnan(organised[kAzimuth][3]));
}

TEST(Gather, AddedReturnsAreCountedFromTheNearest) {
  const World world = makeWorld(4, 9, 20);
  Returns returns;
  returns.start(world.hits);
  returns.add({.beam = 13, .range = 3, .cause = Reason::FalsePositive, .label = 9}, world.hits);
  returns.remove(5);
  Scan scan;
  gather(world.hits, world.shot, returns, kDense, nullptr, scan);
  EXPECT_EQ(scan.size(), 36u);
  const auto points = pointsByKey(scan);
  EXPECT_FALSE(points.contains({0, 5, 0})) << "it was removed";
  const std::size_t near = points.at({1, 4, 0});
  const std::size_t far = points.at({1, 4, 1});
  EXPECT_EQ(scan[kReturn][near], 1);
  EXPECT_EQ(scan[kReturn][far], 2);
  EXPECT_EQ(scan[kCause][near], static_cast<std::uint8_t>(Reason::FalsePositive));
  EXPECT_EQ(scan[kCause][far], static_cast<std::uint8_t>(Reason::Surface));
  EXPECT_EQ(scan[kLabel][near], 9);
  EXPECT_EQ(scan[kLabel][far], world.hits.semantic[13]);
  EXPECT_TRUE(std::isnan(scan[kRangeTrue][near])) << "no hit";
  EXPECT_TRUE(std::isnan(scan[kIncidence][near]));
  EXPECT_EQ(scan[kRangeTrue][far], 20);
  EXPECT_NEAR(length(Vec3d(scan.position[near])), 3, 1e-6);
}

}  // namespace
}  // namespace scanmill
