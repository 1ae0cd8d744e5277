#include "town/tiling.h"

#include <cmath>
#include <unordered_map>

#include "base/input_budget.h"

namespace scanmill::town {
namespace {

const Location kGround{"the ground of the town"};  // of errors

constexpr double kOnLine = 1e-4;  // m; if the field of cutAlong() has a smaller absolute value, it counts as zero

// Corners are on a lattice whose spacing is half the smallest leaf's side, so that leaves' centres are on it, too.
class Quadtree {
 public:
  Quadtree(double half, double smallest, const std::function<bool(double, double, double)>& divided)
      : half_(half), divided_(divided) {
    steps_ = 2;
    while (4 * half / static_cast<double>(steps_) > smallest * 1.0001) steps_ *= 2;
    step_ = 2 * half / static_cast<double>(steps_);
  }

  Tiling make() {
    divide(0, 0, steps_);
    for (const Leaf& leaf : leaves_) addLeaf(leaf);
    return std::move(tiling_);
  }

 private:
  struct Leaf {
    std::int64_t x, y, size;  // low corner and side, in steps of the lattice
  };

  double coordinate(std::int64_t i) const { return -half_ + static_cast<double>(i) * step_; }
  static std::uint64_t key(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 | static_cast<std::uint64_t>(y);
  }

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
    leaves_.push_back({x, y, size});
    for (const std::int64_t cx : {x, x + size}) {
      for (const std::int64_t cy : {y, y + size}) corner(cx, cy);
    }
  }

  std::uint32_t corner(std::int64_t x, std::int64_t y) {
    const auto [found, made] = corners_.try_emplace(key(x, y), static_cast<std::uint32_t>(tiling_.points.size()));
    if (made) tiling_.points.push_back({coordinate(x), coordinate(y)});
    return found->second;
  }

  // Appends the points on the side of a leaf from (ax, ay) to (bx, by), without (bx, by). The points include the
  // corners of smaller neighbours.
  void addSide(std::int64_t ax, std::int64_t ay, std::int64_t bx, std::int64_t by) {
    const std::int64_t mx = (ax + bx) / 2;
    const std::int64_t my = (ay + by) / 2;
    const bool divisible = (ax + bx) % 2 == 0 && (ay + by) % 2 == 0;
    if (divisible && corners_.contains(key(mx, my))) {
      addSide(ax, ay, mx, my);
      addSide(mx, my, bx, by);
      return;
    }
    around_.push_back(corners_.at(key(ax, ay)));
  }

  void addLeaf(const Leaf& l) {
    around_.clear();
    addSide(l.x, l.y, l.x + l.size, l.y);
    addSide(l.x + l.size, l.y, l.x + l.size, l.y + l.size);
    addSide(l.x + l.size, l.y + l.size, l.x, l.y + l.size);
    addSide(l.x, l.y + l.size, l.x, l.y);
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
  std::int64_t steps_ = 2;
  double step_ = 1;
  std::vector<Leaf> leaves_;
  std::vector<std::uint32_t> around_;
  std::unordered_map<std::uint64_t, std::uint32_t> corners_;
  Tiling tiling_;
};

}  // namespace

Tiling makeTiling(double half, double smallest, const std::function<bool(double x, double y, double size)>& divided) {
  return Quadtree(half, smallest, divided).make();
}

void cutAlong(Tiling& tiling, const std::function<double(std::uint32_t point)>& field) {
  std::vector<double> value;
  value.reserve(tiling.points.size());
  for (std::uint32_t p = 0; p < tiling.points.size(); ++p) {
    const double v = field(p);
    value.push_back(std::abs(v) < kOnLine ? 0 : v);
  }
  std::unordered_map<std::uint64_t, std::uint32_t> middles;  // index of the new point, by edge
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [found, made] =
        middles.try_emplace(static_cast<std::uint64_t>(a) << 32 | b, static_cast<std::uint32_t>(tiling.points.size()));
    if (made) {
      const double part = value[a] / (value[a] - value[b]);
      tiling.points.push_back(models::lerp(tiling.points[a], tiling.points[b], part));
      value.push_back(0);
    }
    return found->second;
  };
  const auto sign = [&](std::uint32_t v) { return value[v] > 0 ? 1 : value[v] < 0 ? -1 : 0; };
  std::vector<std::array<std::uint32_t, 3>> kept;
  kept.reserve(tiling.triangles.size());
  for (const std::array<std::uint32_t, 3>& t : tiling.triangles) {
    const int signs[3] = {sign(t[0]), sign(t[1]), sign(t[2])};
    const bool above = signs[0] > 0 || signs[1] > 0 || signs[2] > 0;
    const bool below = signs[0] < 0 || signs[1] < 0 || signs[2] < 0;
    if (!above || !below) {
      kept.push_back(t);
      continue;
    }
    // Rotates the corners so that the first corner is on the line, or is the only corner on its side of the line.
    std::size_t first = 0;
    while (signs[first] != 0 && first < 3) {
      if (signs[first] != signs[(first + 1) % 3] && signs[first] != signs[(first + 2) % 3] &&
          signs[(first + 1) % 3] != 0 && signs[(first + 2) % 3] != 0) {
        break;
      }
      first = (first + 1) % 3;
    }
    const std::uint32_t a = t[first];
    const std::uint32_t b = t[(first + 1) % 3];
    const std::uint32_t c = t[(first + 2) % 3];
    if (signs[first] == 0) {
      const std::uint32_t m = middle(b, c);
      kept.push_back({a, b, m});
      kept.push_back({a, m, c});
      continue;
    }
    const std::uint32_t ab = middle(a, b);
    const std::uint32_t ac = middle(a, c);
    kept.push_back({a, ab, ac});
    kept.push_back({ab, b, c});
    kept.push_back({ab, c, ac});
  }
  tiling.triangles = std::move(kept);
}

}  // namespace scanmill::town
