#include "scene/connected_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

namespace scanmill {
namespace {

struct PlaceHash {
  std::size_t operator()(const Vec3f& p) const {
    std::uint64_t hash = 0;
    for (const float value : {p.x, p.y, p.z}) {
      hash = (hash ^ std::bit_cast<std::uint32_t>(value + 0.0f)) * 0x9E3779B97F4A7C15;  // -0 is 0
      hash ^= hash >> 29;
    }
    return hash;
  }
};

struct SamePlace {
  bool operator()(const Vec3f& a, const Vec3f& b) const { return a.x == b.x && a.y == b.y && a.z == b.z; }
};

bool holds(const Box& box, const Vec3d& p) {
  return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y &&
         p.z <= box.high.z;
}

// Boxes by the columns, as seen from above, that they are in.
class Columns {
 public:
  explicit Columns(const Box& all) : low_(all.low) {
    const Vec3d size = all.high - all.low;
    perMetre_ = kCells / std::max({size.x, size.y, 1e-9});
    cells_.resize(kCells * kCells);
  }

  void add(const Box& box, std::uint32_t number) {
    const auto [fromX, fromY] = cellOf(box.low);
    const auto [toX, toY] = cellOf(box.high);
    for (std::size_t x = fromX; x <= toX; ++x) {
      for (std::size_t y = fromY; y <= toY; ++y) cells_[x * kCells + y].push_back(number);
    }
  }

  const std::vector<std::uint32_t>& at(const Vec3d& p) const {
    const auto [x, y] = cellOf(p);
    return cells_[x * kCells + y];
  }

 private:
  static constexpr std::size_t kCells = 128;
  std::array<std::size_t, 2> cellOf(const Vec3d& p) const {
    const auto along = [&](double d) {
      return std::min(static_cast<std::size_t>(std::max(d, 0.0) * perMetre_), kCells - 1);
    };
    return {along(p.x - low_.x), along(p.y - low_.y)};
  }

  Vec3d low_;
  double perMetre_ = 0;
  std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace

ConnectedParts connect(const std::vector<const AssetPart*>& parts) {
  // Vertices count through all parts; each has at first as its parent the first at its place.
  std::vector<std::uint32_t> parent;
  std::unordered_map<Vec3f, std::uint32_t, PlaceHash, SamePlace> known;
  std::size_t vertices = 0;
  for (const AssetPart* part : parts) vertices += part->positions.size();
  parent.reserve(vertices);
  known.reserve(vertices);
  for (const AssetPart* part : parts) {
    for (const Vec3f& p : part->positions) {
      parent.push_back(known.emplace(p, static_cast<std::uint32_t>(parent.size())).first->second);
    }
  }
  const auto root = [&](std::size_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return static_cast<std::uint32_t>(v);
  };
  std::size_t first = 0;
  for (const AssetPart* part : parts) {
    for (const Triangle& t : part->triangles) {
      const std::uint32_t own = root(first + t[0]);
      for (const std::uint32_t corner : {t[1], t[2]}) parent[root(first + corner)] = own;
    }
    first += part->positions.size();
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numberOf(vertices, kNone);
  ConnectedParts found;
  first = 0;
  for (const AssetPart* part : parts) {
    std::vector<std::uint32_t>& of = found.of.emplace_back();
    of.reserve(part->triangles.size());
    for (const Triangle& t : part->triangles) {
      std::uint32_t& number = numberOf[root(first + t[0])];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(found.boxes.size());
        found.boxes.emplace_back();
      }
      for (const std::uint32_t corner : t) found.boxes[number].add(Vec3d(part->positions[corner]));
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
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return diagonal(a) > diagonal(b); });
  Box all;
  for (const Box& box : connected) {
    if (box.empty()) continue;
    all.add(box.low);
    all.add(box.high);
  }
  std::vector<std::uint32_t> owner(connected.size());
  if (all.empty()) return owner;
  Columns largest(all);
  for (const std::uint32_t i : order) {
    owner[i] = i;
    if (connected[i].empty()) continue;
    const Vec3d middle = connected[i].center();
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t other : largest.at(middle)) {
      const double distance = length(connected[other].center() - middle);
      if (!holds(connected[other], middle) || distance >= nearest) continue;
      nearest = distance;
      owner[i] = other;
    }
    if (owner[i] == i) largest.add(connected[i], i);
  }
  // In the order of the connected parts.
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
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
