#include "report/dataset/scan_counts.h"

#include "sense/echoes.h"
#include "tests/studio/report/dataset/made_dataset.h"

namespace scanmill {
namespace {

TEST(ScanCounts, StepsHoldTheFarthestRange) {
  for (const double farthest : {0.5, 1.0, 7.0, 12.0, 80.0, 120.0, 245.0, 1000.0, 12345.0}) {
    const RangeSteps steps = rangeStepsFor(farthest);
    EXPECT_LE(steps.count, 122u) << farthest;
    EXPECT_GE(double(steps.count - 1) * steps.step, farthest * (1 - 1e-12));
    EXPECT_EQ(steps.of(2 * farthest + steps.step), steps.count - 1);
    EXPECT_EQ(steps.of(0), 0u);
    const double digit = steps.step / std::pow(10, std::floor(std::log10(steps.step) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-9 || std::abs(digit - 2) < 1e-9 || std::abs(digit - 5) < 1e-9) << steps.step;
  }
}

TEST(ScanCounts, IntensityKeysKeepOrderAndBytes) {
  for (int i = 1; i <= 256; ++i) EXPECT_EQ(intensityOfKey(intensityKey(float(i))), float(i));
  float before = 0;
  for (float v = 1e-6f; v < 1e6f; v *= 1.01f) {
    const float of = intensityOfKey(intensityKey(v));
    EXPECT_LE(of, v);
    EXPECT_GT(of, v * (1 - 1.0f / 127));
    EXPECT_GE(of, before);
    before = of;
  }
  EXPECT_EQ(intensityKey(0), 0);
  EXPECT_EQ(intensityKey(-3), 0);
}

TEST(ScanCounts, CountsWhatIsThere) {
  const Manifest manifest = madeManifest();
  std::vector<MadePoint> points;
  for (int k = 0; k < 10; ++k) points.push_back({{float(k) + 0.5f, 0, 0}, 7, 0, 10});
  for (int k = 0; k < 6; ++k) points.push_back({{0, 5, 0}, 65535, k < 4 ? 9u : 0u, 255});
  points.push_back({{0, 5, 0}, 7, 9, 255});
  Scan scan = madeScan(manifest.sensors[0].beams, points);
  scan.position.push_back({NAN, NAN, NAN});  // a miss
  scan[kLabel].push_back(7);
  scan[kInstance].push_back(0);
  scan[kIntensity].push_back(0);
  scan[kRing].push_back(0);
  const RangeSteps steps{1, 8};
  const ScanCounts counts = countScan(scan, steps);
  EXPECT_EQ(counts.points, 17u);
  EXPECT_EQ(counts.rangesOfClass.at(7), (std::vector<std::uint64_t>{1, 1, 1, 1, 1, 2, 1, 3}));
  EXPECT_EQ(counts.rangesOfClass.at(65535), (std::vector<std::uint64_t>{0, 0, 0, 0, 0, 6, 0, 0}));
  EXPECT_EQ(counts.intensities.at(intensityKey(10)), 10u);
  EXPECT_EQ(counts.intensities.at(intensityKey(255)), 7u);
  ASSERT_EQ(counts.instances.size(), 1u);
  EXPECT_EQ(counts.instances[0].id, 9u);
  EXPECT_EQ(counts.instances[0].pointsOfClass, (std::map<std::uint16_t, std::uint64_t>{{7, 1}, {65535, 4}}));
  EXPECT_EQ(counts.withoutId, (std::map<std::uint16_t, std::uint64_t>{{7, 10}, {65535, 2}}));
}

TEST(ScanCounts, AScanWithoutColumnsIsCountedToo) {
  Scan scan;
  scan.position = {{1, 0, 0}, {2, 0, 0}};
  const ScanCounts counts = countScan(scan, {1, 4});
  EXPECT_EQ(counts.points, 2u);
  EXPECT_EQ(counts.rangesOfClass.at(0), (std::vector<std::uint64_t>{0, 1, 1, 0}));
  EXPECT_TRUE(counts.intensities.empty() && counts.instances.empty() && counts.withoutId.empty());
}

// What a window mirrors, and what light strayed from, lies elsewhere than the thing.
TEST(ScanCounts, MirrorImagesAreNoPartOfAThingsSize) {
  const Manifest manifest = madeManifest();
  std::vector<MadePoint> points;
  for (int k = 0; k <= 20; ++k) points.push_back({{5 + 0.1f * float(k), 3, 0.05f * float(k)}, 7, 9, 10});
  points.push_back({{11, 9, 0}, 7, 9, 10});
  points.push_back({{14, 3, 0}, 7, 4, 10});
  Scan scan = madeScan(manifest.sensors[0].beams, points);
  const auto boxOfFirst = [&] { return countScan(scan, {1, 30}).instances.back().box; };
  EXPECT_NEAR(boxOfFirst().high.x, 11, 1e-5) << "nothing tells where points come from";
  scan[kCause].assign(points.size(), static_cast<std::uint8_t>(Cause::Surface));
  scan[kCause][3] = static_cast<std::uint8_t>(Cause::ThroughGlass);
  scan[kCause][21] = static_cast<std::uint8_t>(Cause::Mirrored);
  scan[kCause][22] = static_cast<std::uint8_t>(Cause::Mirrored);
  EXPECT_NEAR(boxOfFirst().high.x, 7, 1e-5);
  EXPECT_NEAR(boxOfFirst().high.z, 1, 1e-5);
  EXPECT_NEAR(countScan(scan, {1, 30}).instances.front().box.high.x, 14, 1e-5) << "all that there is";
}

TEST(ScanCounts, BoxesAreLevelHoweverTheSensorLeans) {
  const Mat3 level = levelFromSensor(fromYawPitchRoll(0.8, 0.2, -0.15));
  EXPECT_NEAR((level * Vec3d{1, 0, 0}).y, 0, 1e-12);
  Scan scan;
  for (const Vec3d& p : {Vec3d{12, 3, -2}, Vec3d{16, 5, -0.5}}) {
    scan.position.push_back(Vec3f(inverse(level) * p));
    scan[kLabel].push_back(1);
    scan[kInstance].push_back(5);
  }
  const Box box = countScan(scan, {1, 40}, level).instances.at(0).box;
  EXPECT_NEAR(length(box.low - Vec3d{12, 3, -2}), 0, 1e-5);
  EXPECT_NEAR(length(box.high - Vec3d{16, 5, -0.5}), 0, 1e-5);
}

}  // namespace
}  // namespace scanmill
