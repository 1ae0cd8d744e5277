#include "methods/device/wide_hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include "base/random.h"
#include "methods/world/world.h"

namespace scanmill {
namespace {

std::vector<PrimitiveBox> scattered(std::size_t count, double spread, double size, double shift) {
  std::vector<PrimitiveBox> boxes;
  for (std::uint32_t i = 0; i < count; ++i) {
    const RandomBlock a = randomBlock({.beam = i, .purpose = Purpose::Test});
    const RandomBlock b = randomBlock({.frame = 1, .beam = i, .purpose = Purpose::Test});
    const Vec3d low{shift + spread * uniform(a[0]), spread * uniform(a[1]), spread * uniform(a[2])};
    const Vec3d high = low + Vec3d{size * uniform(b[0]), size * uniform(b[1]), i % 3 == 0 ? 0 : size * uniform(b[2])};
    boxes.push_back({Vec3f(low), Vec3f(high)});
  }
  return boxes;
}

double along(const Vec3f& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

// Walks it from the root, and gives how often each primitive is met. Every box on the way must enclose it.
class Walk {
 public:
  Walk(const WideHierarchy& hierarchy, std::span<const PrimitiveBox> boxes)
      : hierarchy_(hierarchy), boxes_(boxes), met(boxes.size(), 0) {
    if (!hierarchy.nodes.empty()) node(0, {});
  }

 private:
  struct Slot {
    const WideNode* node;
    std::size_t slot;
  };

  void node(std::uint32_t index, const std::vector<Slot>& above) {
    ASSERT_LT(index, hierarchy_.nodes.size());
    ASSERT_TRUE(seen_.insert(index).second) << "a node has one parent";
    ASSERT_LE(above.size(), kMostWideDepth);
    const WideNode& n = hierarchy_.nodes[index];
    std::uint32_t inner = 0;
    for (std::size_t slot = 0; slot < kWideChildren; ++slot) {
      std::vector<Slot> here = above;
      here.push_back({&n, slot});
      if ((n.inner >> slot & 1) != 0) {
        EXPECT_NE(n.leaf[slot], 0);
        node(n.firstNode + inner++, here);
      } else if (n.leaf[slot] != 0) {
        const int count = std::popcount(static_cast<unsigned>(n.leaf[slot]) >> 5);
        for (int k = 0; k < count; ++k)
          primitive(n.firstPrimitive + (n.leaf[slot] & 31u) + static_cast<unsigned>(k), here);
      }
    }
  }

  void primitive(std::uint32_t place, const std::vector<Slot>& above) {
    ASSERT_LT(place, hierarchy_.primitives.size());
    const std::uint32_t number = hierarchy_.primitives[place];
    ++met[number];
    for (const auto& [n, slot] : above) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_LE(wideBound(*n, axis, n->low[axis][slot]), along(boxes_[number].low, axis));
        ASSERT_GE(wideBound(*n, axis, n->high[axis][slot]), along(boxes_[number].high, axis));
      }
    }
  }

  const WideHierarchy& hierarchy_;
  std::span<const PrimitiveBox> boxes_;
  std::set<std::uint32_t> seen_;

 public:
  std::vector<int> met;
};

TEST(WideHierarchy, EveryPrimitiveIsInOneLeafAndInEveryBoxAboveIt) {
  const DeviceHandle device = makeDevice();
  for (const std::size_t count : {1, 2, 3, 4, 9, 100, 20'000}) {
    for (const auto& [spread, size, shift] : {std::tuple(100.0, 1.0, 0.0),
                                              {100.0, 1e-6, 0.0},
                                              {1e-3, 1e-4, 5e5},
                                              {1e7, 1.0, -3e6},
                                              {0.0, 0.0, 1e6},
                                              {1e-30, 1e-31, 0.0}}) {
      const std::vector<PrimitiveBox> boxes = scattered(count, spread, size, shift);
      const WideHierarchy made = buildWideHierarchy(device.get(), boxes);
      const Walk walk(made, boxes);
      EXPECT_EQ(std::count(walk.met.begin(), walk.met.end(), 1), static_cast<std::ptrdiff_t>(count))
          << count << " " << spread << " " << size << " " << shift;
      EXPECT_EQ(made.primitives.size(), count);
    }
  }
}

TEST(WideHierarchy, IsOfNoNodesWithoutPrimitives) {
  const DeviceHandle device = makeDevice();
  EXPECT_TRUE(buildWideHierarchy(device.get(), {}).nodes.empty());
}

// Boxes are at most a step larger on each side than what they hold, as far as float32 can tell.
TEST(WideHierarchy, BoxesAreTight) {
  const DeviceHandle device = makeDevice();
  const std::vector<PrimitiveBox> boxes = scattered(5'000, 100, 1, 0);
  const WideHierarchy made = buildWideHierarchy(device.get(), boxes);
  for (const WideNode& node : made.nodes) {
    for (std::size_t slot = 0; slot < kWideChildren; ++slot) {
      if ((node.inner >> slot & 1) != 0 || node.leaf[slot] == 0) continue;
      Vec3d low{1e9, 1e9, 1e9};
      Vec3d high = -low;
      const int count = std::popcount(static_cast<unsigned>(node.leaf[slot]) >> 5);
      for (int k = 0; k < count; ++k) {
        const auto place = node.firstPrimitive + (node.leaf[slot] & 31u) + static_cast<unsigned>(k);
        const PrimitiveBox& box = boxes[made.primitives[place]];
        low = {std::min(low.x, double{box.low.x}), std::min(low.y, double{box.low.y}),
               std::min(low.z, double{box.low.z})};
        high = {std::max(high.x, double{box.high.x}), std::max(high.y, double{box.high.y}),
                std::max(high.z, double{box.high.z})};
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double step = std::ldexp(1.0, node.exponent[axis] - 127) + 1e-4;
        EXPECT_GT(wideBound(node, axis, node.low[axis][slot]), along(Vec3f(low), axis) - step);
        EXPECT_LT(wideBound(node, axis, node.high[axis][slot]), along(Vec3f(high), axis) + step);
      }
    }
  }
}

}  // namespace
}  // namespace scanmill
