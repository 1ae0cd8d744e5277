#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "base/error.h"
#include "scenefile/labelling.h"
#include "scenefile/rules.h"

namespace scanmill {
namespace {

using Numbers = std::vector<std::vector<std::uint32_t>>;
constexpr std::uint32_t kUnnumbered = std::numeric_limits<std::uint32_t>::max();

// Returns the number of each triangle's thing, by part and triangle. Parts with the same key `keyOf(part)`, and the
// same class if `byClass` is true, are one thing. Things are numbered from 1 in the order of their lowest nodes.
template <class KeyOf>
Numbers numberByKey(const std::vector<ThingTriangles>& parts, bool byClass, const KeyOf& keyOf) {
  using Key = std::pair<decltype(keyOf(*parts.front().part)), std::uint16_t>;
  std::vector<Key> keys;  // by part
  std::map<Key, std::uint32_t> lowestNodes;
  for (const auto& [part, semantic] : parts) {
    const auto node = static_cast<std::uint32_t>(part->nodeIndex);
    keys.emplace_back(keyOf(*part), byClass ? semantic : std::uint16_t{0});
    const auto [lowest, isNew] = lowestNodes.emplace(keys.back(), node);
    if (!isNew) lowest->second = std::min(lowest->second, node);
  }
  std::set<std::pair<std::uint32_t, Key>> byNode;
  for (const auto& [key, node] : lowestNodes) byNode.emplace(node, key);
  std::map<Key, std::uint32_t> numberOfKey;
  for (const auto& [node, key] : byNode) numberOfKey.emplace(key, static_cast<std::uint32_t>(numberOfKey.size() + 1));
  Numbers numbers;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    numbers.emplace_back(parts[i].part->triangles.size(), numberOfKey.at(keys[i]));
  }
  return numbers;
}

// Returns the fraction of a box's footprint (as seen from above) that the footprint of `coverBox` covers, but at least
// 1e-9; 0 if the boxes are more than `gap` (m) apart along some axis.
double coveredShare(const Box& box, const Box& coverBox, double gap) {
  const auto overlap = [&](double Vec3d::*axis) {
    return std::min(box.high.*axis, coverBox.high.*axis) - std::max(box.low.*axis, coverBox.low.*axis);
  };
  if (overlap(&Vec3d::x) < -gap || overlap(&Vec3d::y) < -gap || overlap(&Vec3d::z) < -gap) return 0;
  const auto shareAlong = [&](double Vec3d::*axis) {
    const double edge = box.high.*axis - box.low.*axis;
    return edge > 0 ? std::clamp(overlap(axis) / edge, 0.0, 1.0) : 1.0;
  };
  return std::max(shareAlong(&Vec3d::x) * shareAlong(&Vec3d::y), 1e-9);
}

// A grid over `bounds` that finds the boxes near a given box. Very large boxes are in a separate list, not in cells.
class BoxGrid {
 public:
  explicit BoxGrid(const Box& bounds) : low_(bounds.low), cells_(kSide * kSide * kSide) {
    const Vec3d size = bounds.high - bounds.low;
    const auto cellsPerMetre = [](double edge) { return kSide / std::max(edge, 1e-9); };
    cellsPerMetre_ = {cellsPerMetre(size.x), cellsPerMetre(size.y), cellsPerMetre(size.z)};
  }

  void add(const Box& box, std::uint32_t number) {
    const Cell first = cellOf(box.low);
    const Cell last = cellOf(box.high);
    std::size_t covered = 1;
    for (std::size_t k = 0; k < 3; ++k) covered *= last[k] - first[k] + 1;
    if (covered > kMostCovered) return large_.push_back(number);
    forEachCell(box, [&](std::size_t cell) { cells_[cell].push_back(number); });
  }

  // Calls visit(number) for each box within `gap` (m) of `box`, perhaps several times, and for some farther boxes.
  template <class Visit>
  void forEachNear(const Box& box, double gap, const Visit& visit) const {
    forEachCell({box.low - Vec3d{gap, gap, gap}, box.high + Vec3d{gap, gap, gap}}, [&](std::size_t cell) {
      for (const std::uint32_t number : cells_[cell]) visit(number);
    });
    for (const std::uint32_t number : large_) visit(number);
  }

 private:
  template <class Visit>
  void forEachCell(const Box& box, const Visit& visit) const {
    const Cell first = cellOf(box.low);
    const Cell last = cellOf(box.high);
    for (std::size_t x = first[0]; x <= last[0]; ++x) {
      for (std::size_t y = first[1]; y <= last[1]; ++y) {
        for (std::size_t z = first[2]; z <= last[2]; ++z) visit((x * kSide + y) * kSide + z);
      }
    }
  }

  static constexpr std::size_t kSide = 48;           // cells along each axis
  static constexpr std::size_t kMostCovered = 4096;  // boxes that cover more cells are in `large_`
  using Cell = std::array<std::size_t, 3>;
  Cell cellOf(const Vec3d& p) const {
    const auto index = [](double offset, double cellsPerMetre) {
      return static_cast<std::size_t>(std::clamp(offset * cellsPerMetre, 0.0, static_cast<double>(kSide - 1)));
    };
    const Vec3d offset = p - low_;
    return {index(offset.x, cellsPerMetre_.x), index(offset.y, cellsPerMetre_.y), index(offset.z, cellsPerMetre_.z)};
  }

  Vec3d low_;
  Vec3d cellsPerMetre_;
  std::vector<std::vector<std::uint32_t>> cells_;  // by cell: numbers of the boxes that cover it
  std::vector<std::uint32_t> large_;               // numbers of the boxes that cover many cells
};

// Groups connected parts into things by their bounds (m). Returns, for each connected part, the number of its thing,
// from 0 in the order of the connected parts.
// A part is grouped with a larger part if their boxes are at most 5 cm apart and one of two conditions is true: at
// least a quarter of the smaller box's footprint (as seen from above) lies within the larger box's footprint, as with
// the wheels of a car and the tiers of a tree; or the smaller box's diagonal is less than 0.15 times the larger box's
// diagonal, as with mirrors of a car.
std::vector<std::uint32_t> groupIntoThings(const std::vector<Box>& boxes) {
  constexpr double kMostGap = 0.05;        // m, largest distance between the boxes of two parts of a thing
  constexpr double kLeastShare = 0.25;     // least overlap, as a fraction of the smaller part's footprint
  constexpr double kSmallDiagonal = 0.15;  // largest diagonal of a small part, as a fraction of the larger part's
  Box bounds;
  for (const Box& box : boxes) bounds.add(box);
  if (bounds.empty()) return std::vector<std::uint32_t>(boxes.size());
  const auto diagonal = [&](std::uint32_t i) { return boxes[i].empty() ? 0 : length(boxes[i].high - boxes[i].low); };
  // Larger boxes come first. Boxes of equal size are ordered by position, so that the result does not depend on the
  // order of the triangles.
  std::vector<std::uint32_t> bySize(boxes.size());
  std::iota(bySize.begin(), bySize.end(), 0U);
  std::ranges::stable_sort(bySize, {}, [&](std::uint32_t i) {
    const Vec3d& low = boxes[i].low;
    return std::tuple(-diagonal(i), low.x, low.y, low.z);
  });
  // A part joins the main part that covers most of its footprint. A part that no main part suits becomes a main part.
  std::vector<std::uint32_t> mainPartOf(boxes.size());
  BoxGrid mainParts(bounds);
  for (const std::uint32_t i : bySize) {
    mainPartOf[i] = i;
    if (boxes[i].empty()) continue;
    double largestShare = 0;
    mainParts.forEachNear(boxes[i], kMostGap, [&](std::uint32_t mainPart) {
      const double share = coveredShare(boxes[i], boxes[mainPart], kMostGap);
      const bool belongs = share >= kLeastShare || (share > 0 && diagonal(i) < kSmallDiagonal * diagonal(mainPart));
      if (!belongs || share <= largestShare) return;
      largestShare = share;
      mainPartOf[i] = mainPart;
    });
    if (mainPartOf[i] == i) mainParts.add(boxes[i], i);
  }
  std::vector<std::uint32_t> numberByMainPart(boxes.size(), kUnnumbered);
  std::vector<std::uint32_t> things;
  std::uint32_t thingCount = 0;
  for (const std::uint32_t mainPart : mainPartOf) {
    if (numberByMainPart[mainPart] == kUnnumbered) numberByMainPart[mainPart] = thingCount++;
    things.push_back(numberByMainPart[mainPart]);
  }
  return things;
}

// Groups the connected parts of each class into things by groupIntoThings(). Returns the number of each triangle's
// thing, by part and triangle; things are numbered from 1, in ascending order of their class ids.
Numbers numberByConnection(const std::vector<ThingTriangles>& parts) {
  std::map<std::uint16_t, std::vector<std::size_t>> indicesByClass;  // indices of the parts of each class
  for (std::size_t i = 0; i < parts.size(); ++i) indicesByClass[parts[i].semantic].push_back(i);
  Numbers numbers(parts.size());
  std::uint32_t thingsSoFar = 0;
  for (const auto& [semantic, indices] : indicesByClass) {
    std::vector<const AssetPart*> partsOfClass;
    for (const std::size_t i : indices) partsOfClass.push_back(parts[i].part);
    const ConnectedParts connected = connect(partsOfClass);
    const std::vector<std::uint32_t> things = groupIntoThings(connected.boxes);
    for (std::size_t k = 0; k < indices.size(); ++k) {
      for (const std::uint32_t connectedPart : connected.numbers[k]) {
        numbers[indices[k]].push_back(thingsSoFar + things[connectedPart] + 1);
      }
    }
    if (!things.empty()) thingsSoFar += *std::ranges::max_element(things) + 1;
  }
  return numbers;
}

// Union-find sets of connected vertices. The vertices of all parts are numbered consecutively. At first, vertices at
// the same position are connected; a vertex with a NaN or infinite coordinate is connected to no other vertex.
class VertexSets {
 public:
  explicit VertexSets(const std::vector<const AssetPart*>& parts) {
    std::vector<Vec3f> positions;
    for (const AssetPart* part : parts) {
      // Adding zero replaces minus zero by zero: equal positions must have equal bytes.
      for (const Vec3f& p : part->positions) positions.push_back(p + Vec3f{});
    }
    const std::size_t vertices = positions.size();
    if (vertices > kUnnumbered) throw Error("a file has more than 4294967295 vertices: split it");
    std::vector<std::uint32_t> positionOf(vertices);  // by vertex: number of its position
    const std::size_t positionCount =
        meshopt_generateVertexRemap(positionOf.data(), nullptr, vertices, positions.data(), vertices, sizeof(Vec3f));
    std::vector<std::uint32_t> firstVertexAt(positionCount, kUnnumbered);
    parent_.resize(vertices);
    for (std::uint32_t vertex = 0; vertex < vertices; ++vertex) {
      std::uint32_t& firstVertex = firstVertexAt[positionOf[vertex]];
      if (firstVertex == kUnnumbered || !isFinite(positions[vertex])) firstVertex = vertex;
      parent_[vertex] = firstVertex;
    }
  }

  // Returns the vertex that represents the set of a vertex, and halves the path to it.
  std::uint32_t root(std::size_t vertex) {
    while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
    return static_cast<std::uint32_t>(vertex);
  }

  void join(std::size_t vertex, std::size_t neighbor) { parent_[root(neighbor)] = root(vertex); }

 private:
  std::vector<std::uint32_t> parent_;  // by vertex: a vertex of the same set that is nearer to the root
};

}  // namespace

ThingBounds readThingBounds(Fields& object, ThingBounds::By fallback) {
  using enum ThingBounds::By;
  constexpr std::pair<const char*, ThingBounds::By> kDivisions[]{
      {"object", Object}, {"node", Node}, {"part", Part}, {"/regular expression/", Name}};
  const Value* const value = object.find("instances");
  if (value == nullptr) return {.by = fallback};
  const bool byName = value->kind == Value::Kind::Scalar && isRegex(value->text);
  if (!byName) return {.by = namedChoice(object, "instances", kDivisions, fallback).second, .where = value->where};
  matchedText(value->text, "", value->where);  // throws InputError for an invalid pattern
  return {.by = Name, .pattern = value->text, .where = value->where};
}

Numbers numberThings(const ThingBounds& bounds, const std::vector<ThingTriangles>& parts) {
  if (parts.empty()) return {};
  switch (bounds.by) {
    case ThingBounds::By::Object:
      break;
    case ThingBounds::By::Node:
      return numberByKey(parts, bounds.byClass, [](const AssetPart& part) { return part.nodeIndex; });
    case ThingBounds::By::Part:
      return numberByConnection(parts);
    case ThingBounds::By::Name:
      if (std::ranges::none_of(parts, [&](const ThingTriangles& thingPart) {
            return matchedText(bounds.pattern, thingPart.part->node, bounds.where).has_value();
          })) {
        warn(
            "{}: the pattern {} matches no node of a class of things, so that each node becomes an "
            "instance, such as '{}'",
            bounds.where.text(), bounds.pattern, parts.front().part->node);
      }
      return numberByKey(parts, bounds.byClass, [&](const AssetPart& part) {
        const std::optional<std::string> text = matchedText(bounds.pattern, part.node, bounds.where);
        return text ? "name " + *text : fmt::format("node {}", part.nodeIndex);
      });
  }
  Numbers ones;
  for (const ThingTriangles& thingPart : parts) ones.emplace_back(thingPart.part->triangles.size(), 1);
  return ones;
}

ConnectedParts connect(const std::vector<const AssetPart*>& parts) {
  VertexSets sets(parts);
  std::size_t firstVertex = 0;  // index of the part's first vertex among those of all parts
  for (const AssetPart* part : parts) {
    for (const Triangle& t : part->triangles) {
      for (const std::uint32_t corner : {t[1], t[2]}) sets.join(firstVertex + t[0], firstVertex + corner);
    }
    firstVertex += part->positions.size();
  }
  std::vector<std::uint32_t> numberByRoot(firstVertex, kUnnumbered);
  ConnectedParts connected;
  firstVertex = 0;
  for (const AssetPart* part : parts) {
    std::vector<std::uint32_t>& numbers = connected.numbers.emplace_back();
    numbers.reserve(part->triangles.size());
    for (const Triangle& t : part->triangles) {
      std::uint32_t& partNumber = numberByRoot[sets.root(firstVertex + t[0])];
      if (partNumber == kUnnumbered) {
        partNumber = static_cast<std::uint32_t>(connected.boxes.size());
        connected.boxes.emplace_back();
      }
      for (const std::uint32_t corner : t) {
        if (isFinite(part->positions[corner])) connected.boxes[partNumber].add(Vec3d(part->positions[corner]));
      }
      numbers.push_back(partNumber);
    }
    firstVertex += part->positions.size();
  }
  return connected;
}

}  // namespace scanmill
