// Fields that move share their bricks.

#include <memory>
#include <vector>

#include "methods/field/distance_field.h"
#include "tests/core/methods/field/triangle_soup.h"
#include "tests/support/on_threads.h"

namespace scanmill {
namespace {

// A field that moves appends its new bricks to those that are there, until there is no more room; what is there stays
// as it is, for others may be reading it.
TEST(MovedField, SharesItsBricks) {
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const auto world = worldOf(scene);
  for (const bool lists : {false, true}) {
    const auto shape = [&](double x) { return shapeAt({x, 0.3 * x, 0}, 0.1, 32, 3, lists); };
    const auto first = buildField(*world, shape(0));
    EXPECT_EQ(first->distance.size(), fullBricks(*first) * kBrickStride);
    auto at = buildField(*world, shape(0.4), {first});
    EXPECT_NE(at->pool, first->pool) << "a field that has not moved before has no room";
    std::size_t shared = 0;
    std::size_t pools = 1;
    for (int step = 2; step < 40; ++step) {
      const std::vector<std::uint16_t> distance(at->distance.begin(), at->distance.end());
      const std::vector<std::uint32_t> word(at->triangleOrList.begin(), at->triangleOrList.end());
      const std::vector<std::uint32_t> entries(at->lists.begin(), at->lists.end());
      const auto next = buildField(*world, shape(step % 2 == 0 ? 0 : 0.1 * step), {at});
      EXPECT_TRUE(std::ranges::equal(distance, at->distance));
      EXPECT_TRUE(std::ranges::equal(word, at->triangleOrList));
      EXPECT_TRUE(std::ranges::equal(entries, at->lists));
      if (next->pool == at->pool) {
        ++shared;
        EXPECT_GE(next->distance.size(), at->distance.size());
        EXPECT_EQ(next->distance.data(), at->distance.data());
      } else {
        ++pools;
        EXPECT_EQ(next->distance.size(), fullBricks(*next) * kBrickStride) << "no brick that nobody reads";
      }
      EXPECT_TRUE(sameField(*next, *buildField(*world, shape(step % 2 == 0 ? 0 : 0.1 * step))));
      at = next;
    }
    EXPECT_GT(shared, 5u);
    EXPECT_GT(pools, 1u);
  }
}

// Between two places, of which each field is known, nothing is made anew.
TEST(MovedField, TakesOverFromSeveralFields) {
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const auto world = worldOf(scene);
  const auto shape = [](double x) { return shapeAt({x, 0, 0}, 0.1, 32, 1, true); };
  const auto start = buildField(*world, shape(0));
  const auto here = buildField(*world, shape(0.8), {start});
  const auto there = buildField(*world, shape(1.6), {here});
  ASSERT_EQ(there->pool, here->pool);
  const auto both = buildField(*world, shape(0.8), {there, here});
  EXPECT_EQ(both->distance.size(), there->distance.size());
  EXPECT_EQ(both->table, here->table);
  const auto one = buildField(*world, shape(0.8), {there});
  EXPECT_GT(one->distance.size(), there->distance.size());
  EXPECT_TRUE(sameField(*one, *both));
}

// Several threads may move the same field, while others read it.
TEST(MovedField, MovesOnSeveralThreads) {
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const auto world = worldOf(scene);
  const auto start = buildField(*world, shapeAt({}, 0.1, 32, 3, true));
  const auto roomy = buildField(*world, shapeAt({0.8, 0, 0}, 0.1, 32, 3, true), {start});
  onThreads(4, [&](std::size_t thread) {
    for (int step = 1; step <= 4; ++step) {
      const FieldShape shape = shapeAt({thread % 2 == 0 ? 0.8 : 1.6, 0.4 * step, 0}, 0.1, 32, 3, true);
      const auto moved = buildField(*world, shape, {roomy});
      EXPECT_TRUE(sameField(*moved, *buildField(*world, shape)));
    }
  });
}

TEST(MovedField, IsAsIfBuiltAnew) {
  auto triangles = soup(40, 8, 0.05, 6);
  for (const auto& leaf : soup(4000, 0.7, 0.01, 0.1)) triangles.push_back(leaf);
  const Scene scene = sceneOf(triangles);
  const auto world = worldOf(scene);
  for (const bool lists : {false, true}) {
    std::vector<std::shared_ptr<const DistanceField>> before;  // one, then two
    const std::vector<Vec3d> path{{0, 0, 0},   {1.7, 0, 0}, {1.7, 3.3, -1.6}, {1.7, 3.3, -1.6}, {5, 4, 1},
                                  {-3, -4, 2}, {0, 0, 0},   {40, 0, 0},       {0.9, 0, 0},      {0.9, 0.9, 0}};
    for (const Vec3d& sensor : path) {
      const FieldShape shape = shapeAt(sensor, 0.2, 32, 3, lists);
      const auto fresh = buildField(*world, shape);
      const auto moved = buildField(*world, shape, before);
      EXPECT_TRUE(sameField(*moved, *fresh)) << "lists " << lists << ", at " << sensor.x;
      before.insert(before.begin(), moved);
      if (before.size() > 2) before.pop_back();
    }
  }
}

TEST(MovedField, TakesOverNothingOfAnotherKind) {
  const Scene scene = sceneOf(soup(40, 2, 0.05, 2));
  const auto world = worldOf(scene);
  const auto before = buildField(*world, shapeAt({}, 0.1, 32, 2, false));
  for (const FieldShape& shape : {shapeAt({}, 0.1, 32, 2, true), shapeAt({}, 0.2, 32, 2, false)}) {
    const auto built = buildField(*world, shape, {before});
    EXPECT_TRUE(sameField(*built, *buildField(*world, shape)));
  }
  // Other levels, and other boxes, are taken over as far as they go.
  for (const FieldShape& shape : {shapeAt({}, 0.1, 32, 3, false), shapeAt({}, 0.1, 16, 1, false)}) {
    const auto built = buildField(*world, shape, {before});
    EXPECT_TRUE(sameField(*built, *buildField(*world, shape)));
  }
}

}  // namespace
}  // namespace scanmill
