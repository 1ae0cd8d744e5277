#include "charts/label_places.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace scanmill {

namespace {

constexpr double kGap = 3;  // pixels between a mark and its label

bool inside(const ChartBox& box, const ChartBox& area) {
  return box.left >= area.left && box.right <= area.right && box.top >= area.top && box.bottom <= area.bottom;
}

// Liang and Barsky's clipping (ACM Transactions on Graphics, 1984): is any of the segment within the box?
bool meets(const Vec2d& a, const Vec2d& b, const ChartBox& box) {
  double enters = 0, leaves = 1;
  const auto clip = [&](double delta, double distance) {
    if (delta == 0) return distance >= 0;
    const double t = distance / delta;
    if (delta < 0) {
      enters = std::max(enters, t);
    } else {
      leaves = std::min(leaves, t);
    }
    return enters <= leaves;
  };
  return clip(a.x - b.x, a.x - box.left) && clip(b.x - a.x, box.right - a.x) && clip(a.y - b.y, a.y - box.top) &&
         clip(b.y - a.y, box.bottom - a.y);
}

bool segmentsCross(const Vec2d& a, const Vec2d& b, const Vec2d& c, const Vec2d& d) {
  const auto side = [](const Vec2d& from, const Vec2d& to, const Vec2d& p) {
    return (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x) > 0;
  };
  return side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b);
}

Vec2d nearestOf(const ChartBox& box, const Vec2d& point) {
  return {std::clamp(point.x, box.left, box.right), std::clamp(point.y, box.top, box.bottom)};
}

// The box whose centre lies in the direction (dx, dy), each -1, 0 or 1, from the mark.
ChartBox boxAt(const LabelWish& wish, double dx, double dy, double distance) {
  const double diagonal = dx != 0 && dy != 0 ? 0.75 : 1;
  const double offset = wish.radius + kGap + distance;
  const double x = wish.point.x + dx * (offset * diagonal + wish.width / 2);
  const double y = wish.point.y + dy * (offset * diagonal + wish.height / 2);
  return {x - wish.width / 2, y - wish.height / 2, x + wish.width / 2, y + wish.height / 2};
}

struct Try {
  double dx, dy;
  double cost;
};
constexpr std::array<Try, 8> kTries{
    {{1, 0, 0}, {-1, 0, 0.4}, {0, -1, 0.6}, {0, 1, 0.7}, {1, -1, 0.8}, {1, 1, 0.9}, {-1, -1, 1.0}, {-1, 1, 1.1}}};
constexpr std::array<double, 4> kDistances{0, 12, 26, 44};
constexpr std::array<double, 3> kFarDistances{70, 100, 140};  // of labels that must stand somewhere

class LabelPlacer {
 public:
  LabelPlacer(const ChartBox& area, std::span<const ChartBox> marks, std::span<const Vec2d> lines)
      : area_(area), marks_(marks), lines_(lines) {}

  std::optional<LabelPlace> place(const LabelWish& wish) {
    std::optional<LabelPlace> best;
    double bestCost = 0;
    bool uponMarks = false;
    const auto consider = [&](const ChartBox& box, double cost, bool leader) {
      if (!inside(box, area_) || coveredByText(box) || (!uponMarks && coveredByMark(box))) return;
      if (leader && !leads(wish, box)) return;
      for (std::size_t i = 0; i + 1 < lines_.size(); i += 2) cost += meets(lines_[i], lines_[i + 1], box) ? 3 : 0;
      if (best && cost >= bestCost) return;
      best = LabelPlace{box, leader};
      bestCost = cost;
    };
    if (wish.side != LabelWish::Side::Any) {
      const bool right = wish.side == LabelWish::Side::Right;
      consider(boxAt(wish, right ? 1 : 0, right ? 0 : -1, 0), 0, false);
    } else {
      const auto around = [&](double distance) {
        for (const Try& attempt : kTries) {
          consider(boxAt(wish, attempt.dx, attempt.dy, distance), attempt.cost + distance / 6, distance > 0);
        }
      };
      for (const double distance : kDistances) around(distance);
      if (wish.needed && !best) {
        for (const double distance : kFarDistances) around(distance);
      }
      if (wish.needed && !best) {
        uponMarks = true;
        around(0);
      }
    }
    if (best) {
      labels_.push_back(best->box);
      if (best->leader) leaders_.insert(leaders_.end(), {wish.point, nearestOf(best->box, wish.point)});
    }
    return best;
  }

 private:
  bool coveredByMark(const ChartBox& box) const {
    return std::any_of(marks_.begin(), marks_.end(), [&](const ChartBox& other) { return box.overlaps(other); });
  }

  bool coveredByText(const ChartBox& box) const {
    const auto overlaps = [&](const ChartBox& other) { return box.overlaps(other); };
    if (std::any_of(labels_.begin(), labels_.end(), overlaps)) return true;
    for (std::size_t i = 0; i < leaders_.size(); i += 2) {
      if (meets(leaders_[i], leaders_[i + 1], box)) return true;
    }
    return false;
  }

  // A leader that crosses another, or its text or mark, would name the wrong point.
  bool leads(const LabelWish& wish, const ChartBox& box) const {
    const Vec2d end = nearestOf(box, wish.point);
    const auto crossed = [&](const ChartBox& other) { return meets(wish.point, end, other); };
    if (std::any_of(labels_.begin(), labels_.end(), crossed)) return false;
    for (std::size_t i = 0; i < leaders_.size(); i += 2) {
      if (segmentsCross(wish.point, end, leaders_[i], leaders_[i + 1])) return false;
    }
    return std::none_of(marks_.begin(), marks_.end(), [&](const ChartBox& mark) {
      const bool own = mark.left <= wish.point.x && wish.point.x <= mark.right && mark.top <= wish.point.y &&
                       wish.point.y <= mark.bottom;
      return !own && crossed(mark);
    });
  }

  ChartBox area_;
  std::span<const ChartBox> marks_;
  std::span<const Vec2d> lines_;
  std::vector<ChartBox> labels_;
  std::vector<Vec2d> leaders_;  // pairs of ends
};

}  // namespace

std::vector<std::optional<LabelPlace>> placeLabels(std::span<const LabelWish> wishes, const ChartBox& area,
                                                   std::span<const ChartBox> marks, std::span<const Vec2d> lines) {
  LabelPlacer placer(area, marks, lines);
  std::vector<std::optional<LabelPlace>> places;
  places.reserve(wishes.size());
  for (const LabelWish& wish : wishes) places.push_back(placer.place(wish));
  return places;
}

}  // namespace scanmill
