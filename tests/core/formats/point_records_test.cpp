#include "base/error.h"
#include "formats/readers.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::string bytesOf(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

TEST(PointRecords, AreKnownByTheirNames) {
  EXPECT_EQ(numbersOfRecord("velodyne/000000.bin"), 4u);
  EXPECT_EQ(numbersOfRecord("x__LIDAR_TOP__1.pcd.bin"), 5u);
  EXPECT_EQ(numbersOfRecord("a.pcd"), 0u);
}

// KITTI's order: ring after ring from the top, each once round from straight ahead, azimuths a little out of order.
TEST(PointRecords, RingsOfKittiAreCountedByTheOrderOfPoints) {
  constexpr int kRings = 64, kColumns = 500;
  std::vector<float> values;
  std::vector<std::uint16_t> rings;
  for (int r = 0; r < kRings; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      if ((r * 31 + c * 17) % 11 == 0) continue;  // lost
      const double azimuth = 2 * kPi * (c + 0.3 * std::sin(7.0 * c)) / kColumns + 1e-3;
      const double elevation = radians(2 - 26.0 * r / kRings);
      for (const double v : {10 * std::cos(azimuth), 10 * std::sin(azimuth), 10 * std::tan(elevation), 0.5}) {
        values.push_back(static_cast<float>(v));
      }
      rings.push_back(static_cast<std::uint16_t>(r));
    }
  }
  const Scan scan = readPointRecords(bytesOf(values), 4, "a.bin");
  EXPECT_EQ(scan.rings, 64u);
  EXPECT_EQ(scan[kRing], rings);
}

TEST(PointRecords, AnotherOrderHasNoRings) {
  std::vector<float> values;
  for (int c = 0; c < 300; ++c) {
    for (int r = 0; r < 16; ++r) {
      for (const double v : {10 * std::cos(0.02 * c), 10 * std::sin(0.02 * c), -0.1 * r, 0.5}) {
        values.push_back(static_cast<float>(v));
      }
    }
  }
  EXPECT_TRUE(readPointRecords(bytesOf(values), 4, "a.bin")[kRing].empty());
  EXPECT_EQ(readPointRecords("", 4, "empty.bin").size(), 0u);
}

// Recorders of organised clouds write NaN, or infinity, where a beam has no return. They keep their rows, which labels
// are counted by.
TEST(PointRecords, PointsWithoutACoordinateAreMisses) {
  std::vector<float> values, withRings;
  for (int r = 0; r < 32; ++r) {
    for (int c = 0; c < 100; ++c) {
      const double azimuth = 2 * kPi * (c + 0.5) / 100;
      const bool miss = c % 10 == 9;
      for (const double v : {10 * std::cos(azimuth), 10 * std::sin(azimuth), -0.1 * r, 0.5}) {
        values.push_back(miss ? (c % 20 == 9 ? NAN : INFINITY) : static_cast<float>(v));
      }
      withRings.insert(withRings.end(), values.end() - 4, values.end());
      withRings.push_back(miss ? values.back() : static_cast<float>(r));
    }
  }
  const Scan five = readPointRecords(bytesOf(withRings), 5, "a.pcd.bin");
  ASSERT_EQ(five.size(), 3200u);
  EXPECT_EQ(five[kRing][3198], 31);
  EXPECT_EQ(five[kRing][3199], 0) << "a miss whose ring is no number";
  EXPECT_FALSE(isFinite(five.position[3199]));
  const Scan scan = readPointRecords(bytesOf(values), 4, "a.bin");
  ASSERT_EQ(scan.size(), 3200u);
  EXPECT_EQ(scan.rings, 32u);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    EXPECT_EQ(isFinite(scan.position[i]), i % 10 != 9) << i;
    EXPECT_EQ(scan[kIntensity][i], i % 10 == 9 ? 0 : 0.5f) << i;
    EXPECT_EQ(scan[kRing][i], i / 100) << i;
  }
}

TEST(PointRecords, WhatAreNoneIsRefused) {
  const auto refused = [](const std::vector<float>& values, std::size_t numbers) {
    return messageOf([&] { readPointRecords(bytesOf(values), numbers, "a.bin"); });
  };
  EXPECT_THAT(refused({1, 2, 3}, 4), HasSubstr("a.bin: has 12 bytes, which are no whole records of 4 float32"));
  EXPECT_THAT(refused({1, 2, NAN, 0, NAN, NAN, NAN, NAN}, 4), HasSubstr("no coordinate of a point is finite"));
  EXPECT_THAT(refused({1, 2, 3, 0, 1, 1e7f, 0, 0}, 4), HasSubstr("point 1 lies at"));
  // Records of x, y, z, intensity and ring, and of x, y and z.
  for (const std::size_t numbers : {std::size_t{5}, std::size_t{3}}) {
    std::vector<float> others;
    for (int i = 0; i < 64; ++i) {
      const auto turn = static_cast<float>(i);
      const std::vector<float> record{10 * std::cos(turn), 10 * std::sin(turn), -1.5f, 40, 7};
      others.insert(others.end(), record.begin(), record.begin() + static_cast<std::ptrdiff_t>(numbers));
    }
    EXPECT_THAT(refused(others, 4), testing::AllOf(HasSubstr("intensities are below 0"), HasSubstr(".pcd.bin"),
                                                   HasSubstr("numpy.fromfile")));
  }
  EXPECT_THAT(refused({1, 2, 3, 0, 1.5f}, 5), HasSubstr("the ring of point 0 is 1.5"));
  EXPECT_THAT(refused({1, 2, 3, 0, -1}, 5), HasSubstr("the ring of point 0 is -1"));
}

}  // namespace
}  // namespace scanmill
