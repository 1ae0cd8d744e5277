// A device makes the processor's bricks, byte by byte.

#include "methods/field/device_bricks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "methods/field/build.h"
#include "tests/core/methods/field/triangle_soup.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"
#include "tests/support/street.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

void expectTheProcessorsField(DeviceBricks& device, const std::shared_ptr<const World>& world,
                              const FieldShape& shape) {
  device.hold(world);
  const auto there = buildField(*world, shape, {}, &device);
  EXPECT_TRUE(sameField(*there, *buildField(*world, shape)));
}

TEST(DeviceBricks, AreTheProcessors) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  auto mixed = soup(30, 3, 0.05, 6);  // lawns, and a bush
  for (const auto& leaf : soup(900, 0.3, 0.01, 0.1)) mixed.push_back(leaf);
  auto huge = soup(8, 0.05, 0.01, 0.1);
  huge.push_back({Vec3f{-4000, -3000, 0.013f}, {5000, -2500, 0.017f}, {100, 6000, -0.004f}});
  for (const bool lists : {false, true}) {
    for (const auto& triangles : {soup(60, 3, 0.003, 5), mixed}) {
      const Scene scene = sceneOf(triangles);
      expectTheProcessorsField(device, worldOf(scene), shapeAt({0.2, 0.1, -0.3}, 0.1, 32, 3, lists));
    }
    const Scene scene = sceneOf(huge);
    expectTheProcessorsField(device, worldOf(scene), shapeAt({0.003, 0.001, 0}, 0.001, 32, 4, lists));
  }
}

TEST(DeviceBricks, OfLinesAndPointsAndCopies) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  const Vec3f a{0.13f, 0.21f, 0.11f};
  const Vec3f b{0.73f, 0.25f, 0.51f};
  const Vec3f c{-0.3f, 0.2f, 0.4f};
  const Vec3f nearB{0.73f, 0.25001f, 0.51f};
  auto triangles = soup(40, 1, 0.1, 1);
  for (int copy = 0; copy < 2; ++copy) triangles.insert(triangles.end(), triangles.begin(), triangles.begin() + 40);
  for (const std::array<Vec3f, 3>& slim : {std::array{a, a, a}, {a, b, a}, {a, b, nearB}, {c, c, b}, {b, c, nearB}}) {
    triangles.push_back(slim);
  }
  // In planes and lines of corners: many are equally near.
  triangles.push_back({Vec3f{0, 0, 0.8f}, {1.6f, 0, 0.8f}, {0, 1.6f, 0.8f}});
  triangles.push_back({Vec3f{0, 0, 0.8f}, {-1.6f, 0, 0.8f}, {0, -1.6f, 0.8f}});
  const Scene scene = sceneOf(triangles);
  for (const bool lists : {false, true}) {
    expectTheProcessorsField(device, worldOf(scene), shapeAt({}, 0.1, 32, 2, lists));
  }
}

TEST(DeviceBricks, FarFromTheOrigin) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  const Vec3d place{511.3, -498.7, 70.1};
  const Scene scene = sceneOf(soup(40, 0.02, 0.0005, 0.03), place);
  for (const bool lists : {false, true}) {
    expectTheProcessorsField(device, worldOf(scene), shapeAt(place, 0.001, 32, 2, lists));
  }
}

// Only where numbers are next to nothing.
TEST(DeviceBricks, LeaveNothingToTheProcessor) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const std::shared_ptr<const World> world = worldOf(scene);
  device.hold(world);
  std::vector<BrickPlace> places;
  for (int i = 0; i < 64; ++i) places.push_back({{0.8 * (i % 4), 0.8 * (i / 4 % 4), 0.8 * (i / 16)}, 0.1});
  std::vector<float> distances(places.size());
  device.centres(places, distances);
  for (const float distance : distances) EXPECT_FALSE(std::isnan(distance));
  for (const bool lists : {false, true}) {
    std::atomic<std::size_t> made = 0;
    device.make(places, lists, [&](std::size_t, const DeviceBricks::Made& brick) { made += brick.left ? 0 : 1; });
    EXPECT_EQ(made, places.size());
  }
}

TEST(DeviceBricks, OfAFieldThatMoves) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const std::shared_ptr<const World> world = worldOf(scene);
  device.hold(world);
  for (const bool lists : {false, true}) {
    const auto shape = [&](double x) { return shapeAt({x, 0.3 * x, 0}, 0.1, 32, 3, lists); };
    auto at = buildField(*world, shape(0), {}, &device);
    for (int step = 1; step < 8; ++step) {
      at = buildField(*world, shape(0.4 * step), {at}, &device);
      EXPECT_TRUE(sameField(*at, *buildField(*world, shape(0.4 * step)))) << step;
    }
  }
}

// A part of the procedural street, with worlds that take turns.
TEST(DeviceBricks, TheProceduralStreet) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  for (const std::uint32_t seed : {1u, 2u}) {
    const Scene street = proceduralStreet(seed);
    const std::shared_ptr<const World> world = worldOf(street);
    for (const bool lists : {false, true}) {
      expectTheProcessorsField(device, world, shapeAt({-20, -1.75, 1.9}, 0.1, 16, 2, lists));
    }
  }
}

TEST(DeviceBricks, EmptyWorldsNeedNoDevice) {
  SKIP_WITHOUT_GL();
  DeviceBricks device;
  const Scene scene = sceneOf({});
  expectTheProcessorsField(device, worldOf(scene), shapeAt({}, 0.1, 32, 2, true));
}

TEST(DeviceBricks, SaysWhatDoesNotFit) {
  SKIP_WITHOUT_GL();
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const std::shared_ptr<const World> world = worldOf(scene);
  DeviceBricks none(1000);
  EXPECT_THAT(messageOf<Error>([&] { none.hold(world); }), HasSubstr("the scene's hierarchy take"));
  DeviceBricks few(9000);
  few.hold(world);
  EXPECT_THAT(messageOf<Error>([&] { buildField(*world, shapeAt({}, 0.1, 32, 2, true), {}, &few); }),
              HasSubstr("take larger voxels"));
}

}  // namespace
}  // namespace scanmill
