#include "scenefile/connected_parts.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>

#include "base/error.h"

namespace scanmill {
namespace {

// Returns the fraction of a box's footprint (as seen from above) that the footprint of another box covers, but at least
// 1e-9; 0 if the boxes are more than `gap` (m) apart along some axis.
double shareOver(const Box& box, const Box& other, double gap) {
  const auto overlap = [&](double Vec3d::*axis) {
    return std::min(box.high.*axis, other.high.*axis) - std::max(box.low.*axis, other.low.*axis);
  };
  if (overlap(&Vec3d::x) < -gap || overlap(&Vec3d::y) < -gap || overlap(&Vec3d::z) < -gap) return 0;
  const auto share = [&](double Vec3d::*axis) {
    const double edge = box.high.*axis - box.low.*axis;
    return edge > 0 ? std::clamp(overlap(axis) / edge, 0.0, 1.0) : 1.0;
  };
  return std::max(share(&Vec3d::x) * share(&Vec3d::y), 1e-9);
}

// A grid that finds the boxes near a given box. Very large boxes are in a separate list, not in cells.
class Cells {
 public:
  explicit Cells(const Box& all) : low_(all.low), cells_(kSide * kSide * kSide) {
    const Vec3d size = all.high - all.low;
    const auto per = [](double edge) { return kSide / std::max(edge, 1e-9); };
    perMetre_ = {per(size.x), per(size.y), per(size.z)};
  }

  void add(const Box& box, std::uint32_t number) {
    const Cell from = cellOf(box.low);
    const Cell to = cellOf(box.high);
    std::size_t covered = 1;
    for (std::size_t k = 0; k < 3; ++k) covered *= to[k] - from[k] + 1;
    if (covered > kMostCovered) return large_.push_back(number);
    forEachCell(box, [&](std::size_t cell) { cells_[cell].push_back(number); });
  }

  // Calls `use` with the number of each box near `box`, perhaps several times for the same number.
  template <class Use>
  void forEachNear(const Box& box, double gap, const Use& use) const {
    forEachCell({box.low - Vec3d{gap, gap, gap}, box.high + Vec3d{gap, gap, gap}}, [&](std::size_t cell) {
      for (const std::uint32_t number : cells_[cell]) use(number);
    });
    for (const std::uint32_t number : large_) use(number);
  }

 private:
  template <class Use>
  void forEachCell(const Box& box, const Use& use) const {
    const Cell from = cellOf(box.low);
    const Cell to = cellOf(box.high);
    for (std::size_t x = from[0]; x <= to[0]; ++x) {
      for (std::size_t y = from[1]; y <= to[1]; ++y) {
        for (std::size_t z = from[2]; z <= to[2]; ++z) use((x * kSide + y) * kSide + z);
      }
    }
  }

  static constexpr std::size_t kSide = 48;
  static constexpr std::size_t kMostCovered = 4096;
  using Cell = std::array<std::size_t, 3>;
  Cell cellOf(const Vec3d& p) const {
    const auto along = [](double d, double perMetre) {
      return static_cast<std::size_t>(std::clamp(d * perMetre, 0.0, static_cast<double>(kSide - 1)));
    };
    const Vec3d at = p - low_;
    return {along(at.x, perMetre_.x), along(at.y, perMetre_.y), along(at.z, perMetre_.z)};
  }

  Vec3d low_;
  Vec3d perMetre_;
  std::vector<std::vector<std::uint32_t>> cells_;
  std::vector<std::uint32_t> large_;
};

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Sets of connected vertices of all parts, whose vertices are numbered continuously (union-find). At first, vertices at
// the same position are connected; those at no position stay apart.
class VertexSets {
 public:
  explicit VertexSets(const std::vector<const AssetPart*>& parts) {
    std::vector<Vec3f> positions;
    for (const AssetPart* part : parts) {
      // Adding zero replaces minus zero by zero: equal positions must have equal bytes.
      for (const Vec3f& p : part->positions) positions.push_back(p + Vec3f{});
    }
    const std::size_t vertices = positions.size();
    if (vertices > kNone) throw Error("a file has more than 4294967295 vertices: split it");
    std::vector<std::uint32_t> positionOf(vertices);  // number of the vertex's position
    const std::size_t different =
        meshopt_generateVertexRemap(positionOf.data(), nullptr, vertices, positions.data(), vertices, sizeof(Vec3f));
    std::vector<std::uint32_t> firstAt(different, kNone);
    parent_.resize(vertices);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      std::uint32_t& first = firstAt[positionOf[v]];
      if (first == kNone || !isFinite(positions[v])) first = v;
      parent_[v] = first;
    }
  }

  // Returns the vertex that stands for the set of a vertex.
  std::uint32_t root(std::size_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return static_cast<std::uint32_t>(v);
  }

  // Connects the set of `other` to that of `v`.
  void join(std::size_t v, std::size_t other) { parent_[root(other)] = root(v); }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

ConnectedParts connect(const std::vector<const AssetPart*>& parts) {
  VertexSets sets(parts);
  std::size_t first = 0;  // index of the part's first vertex among those of all parts
  for (const AssetPart* part : parts) {
    for (const Triangle& t : part->triangles) {
      for (const std::uint32_t corner : {t[1], t[2]}) sets.join(first + t[0], first + corner);
    }
    first += part->positions.size();
  }
  std::vector<std::uint32_t> numberOf(first, kNone);  // by root: the number of the connected part
  ConnectedParts found;
  first = 0;
  for (const AssetPart* part : parts) {
    std::vector<std::uint32_t>& of = found.of.emplace_back();
    of.reserve(part->triangles.size());
    for (const Triangle& t : part->triangles) {
      std::uint32_t& number = numberOf[sets.root(first + t[0])];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(found.boxes.size());
        found.boxes.emplace_back();
      }
      for (const std::uint32_t corner : t) {
        if (isFinite(part->positions[corner])) found.boxes[number].add(Vec3d(part->positions[corner]));
      }
      of.push_back(number);
    }
    first += part->positions.size();
  }
  return found;
}

std::vector<std::uint32_t> thingsOf(const std::vector<Box>& connected) {
  std::vector<std::uint32_t> order(connected.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto diagonal = [&](std::uint32_t i) {
    const Box& box = connected[i];
    return box.empty() ? 0 : length(box.high - box.low);
  };
  // Larger boxes come first. Boxes of equal size are ordered by position, so that the result does not depend on the
  // order of the triangles.
  const auto key = [&](std::uint32_t i) {
    const Vec3d& low = connected[i].low;
    return std::tuple(-diagonal(i), low.x, low.y, low.z);
  };
  std::ranges::stable_sort(order, {}, key);
  Box all;
  for (const Box& box : connected) {
    if (box.empty()) continue;
    all.add(box.low);
    all.add(box.high);
  }
  std::vector<std::uint32_t> owner(connected.size());
  if (all.empty()) return owner;
  constexpr double kGap = 0.05;    // m, largest distance between the boxes of two parts of a thing
  constexpr double kShare = 0.25;  // least overlap, as a fraction of the smaller part's footprint
  constexpr double kSmall = 0.15;  // largest diagonal of a small part, as a fraction of the larger part's diagonal
  Cells largest(all);
  for (const std::uint32_t i : order) {
    owner[i] = i;
    if (connected[i].empty()) continue;
    double most = 0;
    largest.forEachNear(connected[i], kGap, [&](std::uint32_t other) {
      const double share = shareOver(connected[i], connected[other], kGap);
      const bool belongs = share >= kShare || (share > 0 && diagonal(i) < kSmall * diagonal(other));
      if (!belongs || share <= most) return;
      most = share;
      owner[i] = other;
    });
    if (owner[i] == i) largest.add(connected[i], i);
  }
  // Numbers the things in the order of the connected parts.
  std::vector<std::uint32_t> number(connected.size(), kNone);
  std::vector<std::uint32_t> things;
  std::uint32_t next = 0;
  for (const std::uint32_t o : owner) {
    if (number[o] == kNone) number[o] = next++;
    things.push_back(number[o]);
  }
  return things;
}

}  // namespace scanmill
