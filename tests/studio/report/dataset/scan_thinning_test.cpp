#include <set>

#include "base/random.h"
#include "report/dataset/scan_view.h"

namespace scanmill {
namespace {

// A sensor 2 m above level ground, as many points in every step of elevation; without labels.
Scan groundScan(std::size_t count) {
  Scan scan;
  for (std::size_t i = 0; i < count; ++i) {
    const RandomBlock random = randomBlock({.scene = 1, .beam = static_cast<std::uint32_t>(i)});
    const double down = radians(1.5 + 30 * uniform(random[0])), azimuth = 2 * kPi * uniform(random[1]);
    const double away = 2 / std::tan(down);
    scan.position.push_back(Vec3f(Vec3d{away * std::cos(azimuth), away * std::sin(azimuth), -2}));
  }
  return scan;
}

std::size_t countBetween(const Scan& scan, const std::vector<std::size_t>& points, double from, double to) {
  return static_cast<std::size_t>(std::ranges::count_if(points, [&](std::size_t i) {
    const double away = length(Vec3d(scan.position[i]));
    return away >= from && away < to;
  }));
}

std::vector<std::size_t> everyPoint(const Scan& scan) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) all.push_back(i);
  }
  return all;
}

TEST(ScanThinning, SmallScansStayWhole) {
  Scan scan = groundScan(500);
  scan.position[7] = {NAN, NAN, NAN};
  EXPECT_EQ(pointsToView(scan, 499), everyPoint(scan));
  EXPECT_TRUE(pointsToView(Scan(), 10).empty());
}

TEST(ScanThinning, FarPointsStayAndNearOnesAreThinnedByTheSquare) {
  const Scan scan = groundScan(50'000);
  const std::vector<std::size_t> kept = pointsToView(scan, 15'000), all = everyPoint(scan);
  EXPECT_NEAR(double(kept.size()), 15'000, 1);
  EXPECT_LE(kept.size(), 15'000u);
  EXPECT_TRUE(std::ranges::is_sorted(kept));
  EXPECT_EQ(std::set<std::size_t>(kept.begin(), kept.end()).size(), kept.size());
  EXPECT_EQ(countBetween(scan, kept, 40, 100), countBetween(scan, all, 40, 100));
  const auto share = [&](double from, double to) {
    return double(countBetween(scan, kept, from, to)) / double(countBetween(scan, all, from, to));
  };
  EXPECT_NEAR(share(6, 6.3) / share(4, 4.2), 2.25, 0.3);
  EXPECT_EQ(pointsToView(scan, 15'000), kept);
}

TEST(ScanThinning, SmallThingsAndRareClassesStayWhole) {
  Scan scan = groundScan(30'000);
  scan[kLabel].assign(scan.size(), 1);
  scan[kInstance].assign(scan.size(), 0);
  for (std::size_t i = 0; i < 300; ++i) {
    scan.position[50 * i] = {2, 0.01f * float(i), -2};  // near: thinned but for its id
    scan[kInstance][50 * i] = 9;
    scan.position[50 * i + 1] = {2, 0.01f * float(i), -2};
    scan[kLabel][50 * i + 1] = 3;
    scan.position[50 * i + 2] = {2, 0.01f * float(i), -2};
  }
  std::size_t thing = 0, rare = 0, plain = 0;
  for (const std::size_t i : pointsToView(scan, 6'000)) {
    thing += scan[kInstance][i] == 9;
    rare += scan[kLabel][i] == 3;
    plain += i % 50 == 2 && i < 15'000;
  }
  EXPECT_EQ(thing, 300u);
  EXPECT_EQ(rare, 300u);
  EXPECT_LT(plain, 30u);
}

// Many small things cannot displace all else.
TEST(ScanThinning, HalfIsLeftForTheRest) {
  Scan scan = groundScan(20'000);
  for (std::size_t i = 0; i < scan.size(); ++i) scan[kInstance].push_back(i < 10'000 ? 1 + std::uint32_t(i / 500) : 0);
  std::size_t without = 0;
  const std::vector<std::size_t> kept = pointsToView(scan, 4'000);
  for (const std::size_t i : kept) without += scan[kInstance][i] == 0;
  EXPECT_NEAR(double(kept.size()), 4'000, 1);
  EXPECT_GE(without, 500u);
}

TEST(ScanThinning, PointsInOnePlaceAreThinnedToo) {
  Scan scan;
  scan.position.assign(5000, Vec3f{0, 0, 0});
  EXPECT_NEAR(double(pointsToView(scan, 1000).size()), 1000, 1);
}

}  // namespace
}  // namespace scanmill
