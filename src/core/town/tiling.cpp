#include "town/tiling.h"

#include <cmath>
#include <unordered_map>

#include "base/input_budget.h"
#include "models/occupancy.h"

namespace scanmill::town {
namespace {

const Location kGround{"the ground of the town"};  // location of errors

constexpr double kOnLine = 1e-4;  // m; smaller absolute values of the field of cutAlong() count as zero

// A quadtree over the square. Integer coordinates and sizes are in steps of a lattice. A step is half of the smallest
// leaf's side, so that the corners and the centres of all leaves are points of the lattice.
class Quadtree {
 public:
  Quadtree(double half, double smallest, const std::function<bool(double, double, double)>& divided)
      : half_(half), divided_(divided), steps_(stepsOf(half, smallest)) {
    step_ = 2 * half / static_cast<double>(steps_);
    leaves_.reserve(kUsual);
    tiling_.points.reserve(kUsual);
    corners_.reserve(kUsual);
  }

  Tiling make() {
    divide(0, 0, steps_);
    tiling_.triangles.reserve(3 * leaves_.size());
    for (const Leaf& leaf : leaves_) addLeaf(leaf);
    return std::move(tiling_);
  }

 private:
  static constexpr std::size_t kUsual = std::size_t{1} << 19;  // approximate number of leaves and of points in a town
  struct Leaf {
    std::int32_t x, y, size;               // low corner and side, in steps of the lattice
    std::array<std::uint32_t, 4> corners;  // indices of the corners, counter-clockwise from the low corner
  };

  // Returns the number of lattice steps along a side of the square, a power of 2.
  static std::int64_t stepsOf(double half, double smallest) {
    std::int64_t steps = 2;
    while (4 * half / static_cast<double>(steps) > smallest * 1.0001) steps *= 2;
    return steps;
  }
  double coordinate(std::int64_t i) const { return -half_ + static_cast<double>(i) * step_; }

  // Adds the leaves of the square with the low corner (x, y), which is divided as divided_ decides.
  void divide(std::int64_t x, std::int64_t y, std::int64_t size) {
    const double side = static_cast<double>(size) * step_;
    chargeTime(kGround);
    if (size > 2 && divided_(coordinate(x) + side / 2, coordinate(y) + side / 2, side)) {
      const std::int64_t half = size / 2;
      divide(x, y, half);
      divide(x + half, y, half);
      divide(x, y + half, half);
      divide(x + half, y + half, half);
      return;
    }
    const std::uint32_t low = corner(x, y);
    const std::uint32_t left = corner(x, y + size);
    const std::uint32_t right = corner(x + size, y);
    const std::uint32_t high = corner(x + size, y + size);
    leaves_.push_back({.x = static_cast<std::int32_t>(x),
                       .y = static_cast<std::int32_t>(y),
                       .size = static_cast<std::int32_t>(size),
                       .corners = {low, right, high, left}});
  }

  // Returns the index of the point at a position of the lattice. Adds the point if it is new.
  std::uint32_t corner(std::int64_t x, std::int64_t y) {
    const auto [found, isNew] =
        corners_.try_emplace(models::cellKey(x, y), static_cast<std::uint32_t>(tiling_.points.size()));
    if (isNew) tiling_.points.push_back({coordinate(x), coordinate(y)});
    return found->second;
  }

  // Appends to around_ the point `first` at (ax, ay) and the corners of smaller leaves between (ax, ay) and (bx, by).
  void addSide(std::uint32_t first, std::int64_t ax, std::int64_t ay, std::int64_t bx, std::int64_t by) {
    const std::int64_t mx = (ax + bx) / 2;
    const std::int64_t my = (ay + by) / 2;
    const bool divisible = (ax + bx) % 2 == 0 && (ay + by) % 2 == 0;
    const auto middle = divisible ? corners_.find(models::cellKey(mx, my)) : corners_.end();
    if (middle == corners_.end()) return around_.push_back(first);
    addSide(first, ax, ay, mx, my);
    addSide(middle->second, mx, my, bx, by);
  }

  // Adds the triangles of a leaf: two or, if corners of smaller neighbours are on its sides, a fan about the centre.
  void addLeaf(const Leaf& l) {
    around_.clear();
    addSide(l.corners[0], l.x, l.y, l.x + l.size, l.y);
    addSide(l.corners[1], l.x + l.size, l.y, l.x + l.size, l.y + l.size);
    addSide(l.corners[2], l.x + l.size, l.y + l.size, l.x, l.y + l.size);
    addSide(l.corners[3], l.x, l.y + l.size, l.x, l.y);
    if (around_.size() == 4) {
      tiling_.triangles.push_back({around_[0], around_[1], around_[2]});
      tiling_.triangles.push_back({around_[0], around_[2], around_[3]});
      return;
    }
    const auto center = static_cast<std::uint32_t>(tiling_.points.size());
    tiling_.points.push_back({coordinate(l.x) + static_cast<double>(l.size) * step_ / 2,
                              coordinate(l.y) + static_cast<double>(l.size) * step_ / 2});
    for (std::size_t i = 0; i < around_.size(); ++i) {
      tiling_.triangles.push_back({center, around_[i], around_[(i + 1) % around_.size()]});
    }
  }

  double half_;
  const std::function<bool(double, double, double)>& divided_;
  std::int64_t steps_;
  double step_ = 1;
  std::vector<Leaf> leaves_;
  std::vector<std::uint32_t> around_;                         // points around the current leaf, counter-clockwise
  std::unordered_map<std::uint64_t, std::uint32_t> corners_;  // index of a point, by its position in the lattice
  Tiling tiling_;
};

}  // namespace

Tiling makeTiling(double half, double smallest, const std::function<bool(double x, double y, double size)>& divided) {
  return Quadtree(half, smallest, divided).make();
}

void cutAlong(Tiling& tiling, std::vector<double> field) {
  using Corners = std::array<std::uint32_t, 3>;
  // Bits for the side of the line on which a point is; 0: on the line. A triangle whose corners have both bits is cut.
  constexpr std::uint8_t kAbove = 1, kBelow = 2;
  std::vector<std::uint8_t> sides(field.size());  // by point
  for (std::size_t p = 0; p < field.size(); ++p) {
    if (std::abs(field[p]) < kOnLine) field[p] = 0;
    sides[p] = field[p] > 0 ? kAbove : field[p] < 0 ? kBelow : 0;
  }
  std::unordered_map<std::uint64_t, std::uint32_t> crossings;  // index of the new point, by edge
  // Returns the index of the point on the edge between a and b where the field is zero. Adds the point if it is new.
  const auto addCrossing = [&](std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto newIndex = static_cast<std::uint32_t>(tiling.points.size());
    const auto [entry, isNew] = crossings.try_emplace(static_cast<std::uint64_t>(a) << 32 | b, newIndex);
    if (isNew) {
      const double t = field[a] / (field[a] - field[b]);
      tiling.points.push_back(models::lerp(tiling.points[a], tiling.points[b], t));
    }
    return entry->second;
  };
  std::vector<Corners> triangles;
  triangles.reserve(tiling.triangles.size() + tiling.triangles.size() / 8);
  for (const Corners& t : tiling.triangles) {
    if ((sides[t[0]] | sides[t[1]] | sides[t[2]]) != (kAbove | kBelow)) {
      triangles.push_back(t);
      continue;
    }
    // Rotates the corners so that the first corner is on the line, or is the only corner on its side of the line.
    const bool onLine = sides[t[0]] == 0 || sides[t[1]] == 0 || sides[t[2]] == 0;
    std::size_t first = 0;
    while (onLine ? sides[t[first]] != 0 : sides[t[(first + 1) % 3]] != sides[t[(first + 2) % 3]]) ++first;
    const std::uint32_t a = t[first];
    const std::uint32_t b = t[(first + 1) % 3];
    const std::uint32_t c = t[(first + 2) % 3];
    if (onLine) {
      const std::uint32_t bc = addCrossing(b, c);
      triangles.insert(triangles.end(), {{a, b, bc}, {a, bc, c}});
    } else {
      const std::uint32_t ab = addCrossing(a, b);
      const std::uint32_t ac = addCrossing(a, c);
      triangles.insert(triangles.end(), {{a, ab, ac}, {ab, b, c}, {ab, c, ac}});
    }
  }
  tiling.triangles = std::move(triangles);
}

}  // namespace scanmill::town
