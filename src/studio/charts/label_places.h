#pragma once

// Text beside points, so that nothing covers anything.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Pixels; y grows downwards.
struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  bool overlaps(const ChartBox& o) const {
    return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
  }
};

struct LabelWish {
  enum class Side { Any, Right, Above };
  Vec2d point;
  double radius = 0;  // of the mark
  double width = 0, height = 0;
  Side side = Side::Any;
  bool needed = false;  // farther away, or upon marks, rather than not at all
};

struct LabelPlace {
  ChartBox box;
  bool leader = false;  // so far away that a line must lead to it
};

// One place per wish, earlier wishes first: inside `area`, clear of each other and of `marks`, and of `lines` (pairs of
// ends) where that can be. None: there is no room, though a needed one may cover marks then.
std::vector<std::optional<LabelPlace>> placeLabels(std::span<const LabelWish> wishes, const ChartBox& area,
                                                   std::span<const ChartBox> marks, std::span<const Vec2d> lines);

}  // namespace scanmill
