#pragma once

// Finds places for text beside points, so that nothing covers anything.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// A box in pixels; y grows downwards.
struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  bool overlaps(const ChartBox& o) const {
    return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
  }
};

// A label that wants a place beside a point.
struct LabelWish {
  enum class Side { Any, Right, Above };
  Vec2d point;
  double radius = 0;             // of the point's mark
  double width = 0, height = 0;  // of the label
  Side side = Side::Any;
  bool needed = false;  // the label rather lies farther away or upon marks than that it is left out
};

struct LabelPlace {
  ChartBox box;
  bool leader = false;  // so far away that a line must lead to it
};

// Finds a place for each wish, the earlier wishes first. Places lie inside `area`, clear of each other and of `marks`,
// and of `lines` (pairs of ends) where that is possible. A place is absent where there is no room; a label that is
// needed covers marks rather than being left out.
std::vector<std::optional<LabelPlace>> placeLabels(std::span<const LabelWish> wishes, const ChartBox& area,
                                                   std::span<const ChartBox> marks, std::span<const Vec2d> lines);

}  // namespace scanmill
