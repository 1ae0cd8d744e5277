#include "methods/device/wide_hierarchy.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

struct TreeNode {
  std::uint32_t count = 0;  // of children; of a leaf: of primitives
  bool leaf = false;
};

struct TreeLeaf : TreeNode {
  std::array<std::uint32_t, kMostWideLeaf> primitives{};
};

struct TreeInner : TreeNode {
  std::array<TreeNode*, kWideChildren> children{};
  std::array<PrimitiveBox, kWideChildren> boxes{};
};

template <class T>
T* make(RTCThreadLocalAllocator allocator) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(T), alignof(T))) T;
}

void* createNode(RTCThreadLocalAllocator allocator, unsigned count, void* /*user*/) {
  auto* node = make<TreeInner>(allocator);
  node->count = count;
  return static_cast<TreeNode*>(node);
}

void setChildren(void* node, void** children, unsigned count, void* /*user*/) {
  auto& inner = *static_cast<TreeInner*>(static_cast<TreeNode*>(node));
  for (unsigned i = 0; i < count; ++i) inner.children[i] = static_cast<TreeNode*>(children[i]);
}

void setBounds(void* node, const RTCBounds** bounds, unsigned count, void* /*user*/) {
  auto& inner = *static_cast<TreeInner*>(static_cast<TreeNode*>(node));
  for (unsigned i = 0; i < count; ++i) {
    const RTCBounds& b = *bounds[i];
    inner.boxes[i] = {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
  }
}

void* createLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count,
                 void* /*user*/) {
  auto* node = make<TreeLeaf>(allocator);
  node->leaf = true;
  node->count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) node->primitives[i] = primitives[i].primID;
  return static_cast<TreeNode*>(node);
}

double at(const Vec3f& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

// Which child goes to which slot: each slot wants the child that lies farthest towards its octant; the strongest wish
// of all is granted first.
std::array<int, kWideChildren> chooseSlots(const TreeInner& node, const PrimitiveBox& whole) {
  std::array<std::array<double, kWideChildren>, kWideChildren> wish{};  // by slot and child
  for (std::size_t child = 0; child < node.count; ++child) {
    for (std::size_t slot = 0; slot < kWideChildren; ++slot) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double beyond = at(node.boxes[child].low, axis) + at(node.boxes[child].high, axis) -
                              (at(whole.low, axis) + at(whole.high, axis));
        wish[slot][child] += (slot >> axis & 1) != 0 ? beyond : -beyond;
      }
    }
  }
  std::array<int, kWideChildren> childOf{};
  childOf.fill(-1);
  std::array<bool, kWideChildren> placed{};
  for (std::size_t n = 0; n < node.count; ++n) {
    double best = -std::numeric_limits<double>::infinity();
    std::size_t bestSlot = 0;
    std::size_t bestChild = 0;
    for (std::size_t slot = 0; slot < kWideChildren; ++slot) {
      for (std::size_t child = 0; child < node.count && childOf[slot] < 0; ++child) {
        if (placed[child] || !(wish[slot][child] > best)) continue;
        best = wish[slot][child];
        bestSlot = slot;
        bestChild = child;
      }
    }
    childOf[bestSlot] = static_cast<int>(bestChild);
    placed[bestChild] = true;
  }
  return childOf;
}

// Sets origin, steps and the children's bounds along one axis, which enclose the boxes as wideBound() computes them.
void quantise(WideNode& node, std::size_t axis, const TreeInner& tree, const std::array<int, kWideChildren>& childOf,
              const PrimitiveBox& whole) {
  constexpr int kLeastExponent = 27;  // 2^-100 m: products with it are exact
  constexpr int kMostExponent = 250;
  constexpr int kMostSteps = 255;
  node.origin[axis] = static_cast<float>(at(whole.low, axis));
  const double extent = at(whole.high, axis) - at(whole.low, axis);
  int exponent = kLeastExponent;
  if (extent > 0)
    exponent = std::max(kLeastExponent, 127 + static_cast<int>(std::ceil(std::log2(extent / kMostSteps))));
  for (;; ++exponent) {
    if (exponent > kMostExponent) throw Error("a scene is too large for a hierarchy on a graphics card");
    node.exponent[axis] = static_cast<std::uint8_t>(exponent);
    const double step = std::ldexp(1.0, exponent - 127);
    bool fits = true;
    for (std::size_t slot = 0; slot < kWideChildren; ++slot) {
      if (childOf[slot] < 0) continue;
      const PrimitiveBox& box = tree.boxes[static_cast<std::size_t>(childOf[slot])];
      const double low = at(box.low, axis);
      const double high = at(box.high, axis);
      auto below = static_cast<int>(std::clamp(std::floor((low - node.origin[axis]) / step), 0.0, 255.0));
      while (below > 0 && wideBound(node, axis, static_cast<std::uint8_t>(below)) > low) --below;
      auto above = static_cast<int>(std::clamp(std::ceil((high - node.origin[axis]) / step), 0.0, 255.0));
      while (above < kMostSteps && wideBound(node, axis, static_cast<std::uint8_t>(above)) < high) ++above;
      fits = fits && wideBound(node, axis, static_cast<std::uint8_t>(above)) >= high;
      node.low[axis][slot] = static_cast<std::uint8_t>(below);
      node.high[axis][slot] = static_cast<std::uint8_t>(above);
    }
    if (fits) return;
  }
}

PrimitiveBox boundsOf(std::span<const PrimitiveBox> boxes) {
  PrimitiveBox whole = boxes.front();
  for (const auto& [low, high] : boxes) {
    whole.low = {std::min(whole.low.x, low.x), std::min(whole.low.y, low.y), std::min(whole.low.z, low.z)};
    whole.high = {std::max(whole.high.x, high.x), std::max(whole.high.y, high.y), std::max(whole.high.z, high.z)};
  }
  return whole;
}

struct ToFlatten {
  const TreeInner* tree;
  std::uint32_t node;
  std::uint32_t depth;
};

// Level by level, so that the children of a node follow each other.
WideHierarchy flatten(const TreeInner& root) {
  WideHierarchy made;
  std::vector<ToFlatten> open{{&root, 0, 1}};
  made.nodes.emplace_back();
  for (std::size_t next = 0; next < open.size(); ++next) {
    const ToFlatten now = open[next];
    if (now.depth > kMostWideDepth) throw Error("a scene's hierarchy is too deep for a graphics card");
    const TreeInner& tree = *now.tree;
    const PrimitiveBox whole = boundsOf(std::span(tree.boxes).first(tree.count));
    const std::array<int, kWideChildren> childOf = chooseSlots(tree, whole);
    WideNode node{};
    node.firstNode = static_cast<std::uint32_t>(made.nodes.size());
    node.firstPrimitive = static_cast<std::uint32_t>(made.primitives.size());
    for (std::size_t axis = 0; axis < 3; ++axis) quantise(node, axis, tree, childOf, whole);
    for (std::size_t slot = 0; slot < kWideChildren; ++slot) {
      if (childOf[slot] < 0) continue;
      const TreeNode* child = tree.children[static_cast<std::size_t>(childOf[slot])];
      if (!child->leaf) {
        node.inner = static_cast<std::uint8_t>(node.inner | 1u << slot);
        node.leaf[slot] = 1;
        open.push_back(
            {static_cast<const TreeInner*>(child), static_cast<std::uint32_t>(made.nodes.size()), now.depth + 1});
        made.nodes.emplace_back();
        continue;
      }
      const auto& leaf = *static_cast<const TreeLeaf*>(child);
      const auto from = static_cast<std::uint32_t>(made.primitives.size()) - node.firstPrimitive;
      node.leaf[slot] = static_cast<std::uint8_t>(((1u << leaf.count) - 1) << 5 | from);
      made.primitives.insert(made.primitives.end(), leaf.primitives.begin(), leaf.primitives.begin() + leaf.count);
    }
    made.nodes[now.node] = node;
  }
  return made;
}

PrimitiveBox boxOf(const TriangleBlock& block, std::uint32_t triangle) {
  const Triangle& corners = block.corners[triangle];
  PrimitiveBox box{block.vertices[corners[0]], block.vertices[corners[0]]};
  for (const std::uint32_t corner : corners) {
    const Vec3f& p = block.vertices[corner];
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

struct HierarchyDeleter {
  void operator()(RTCBVHTy* hierarchy) const { rtcReleaseBVH(hierarchy); }
};

}  // namespace

float wideBound(const WideNode& node, std::size_t axis, std::uint8_t steps) {
  const float step = std::bit_cast<float>(std::uint32_t{node.exponent[axis]} << 23);
  return node.origin[axis] + static_cast<float>(steps) * step;
}

WideHierarchy buildWideHierarchy(RTCDeviceTy* device, std::span<const PrimitiveBox> boxes) {
  if (boxes.empty()) return {};
  std::vector<RTCBuildPrimitive> primitives(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const auto& [low, high] = boxes[i];
    primitives[i] = {low.x, low.y, low.z, 0, high.x, high.y, high.z, static_cast<unsigned>(i)};
  }
  const std::unique_ptr<RTCBVHTy, HierarchyDeleter> hierarchy(rtcNewBVH(device));
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.maxBranchingFactor = kWideChildren;
  arguments.maxDepth = kMostWideDepth - 1;
  arguments.maxLeafSize = kMostWideLeaf;
  arguments.bvh = hierarchy.get();
  arguments.primitives = primitives.data();
  arguments.primitiveCount = primitives.size();
  arguments.primitiveArrayCapacity = primitives.size();
  arguments.createNode = createNode;
  arguments.setNodeChildren = setChildren;
  arguments.setNodeBounds = setBounds;
  arguments.createLeaf = createLeaf;
  auto* const root = static_cast<TreeNode*>(rtcBuildBVH(&arguments));
  if (root == nullptr) throw Error("Embree could not build the hierarchy for a graphics card: out of memory");
  if (!root->leaf) return flatten(*static_cast<const TreeInner*>(root));
  TreeInner above;
  above.count = 1;
  above.children[0] = root;
  above.boxes[0] = boundsOf(boxes);
  return flatten(above);
}

WideHierarchy wideHierarchyOf(RTCDeviceTy* device, const TriangleBlock& block) {
  std::vector<PrimitiveBox> boxes(block.triangles.size());
  parallelFor(boxes.size(), 16384, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) boxes[t] = boxOf(block, static_cast<std::uint32_t>(t));
  });
  return buildWideHierarchy(device, boxes);
}

}  // namespace scanmill
