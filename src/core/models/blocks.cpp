// Builds buildings with any outline: walls with windows, floors and inner walls behind them, a flat or pitched roof.

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>

#include "models/facade.h"

namespace scanmill::models {
namespace {

namespace gtl = boost::polygon;

constexpr double kBelowSlopes = -3;  // m, lower edge of the walls, low enough for sloping ground
constexpr double kRoomDepth = 3.6;   // m, depth of the rooms behind the walls
constexpr double kUnit = 1e-3;       // m per unit of the integer coordinates of Boost.Polygon

using Ring = gtl::polygon_data<int>;
using Region = gtl::polygon_set_data<int>;

Ring ringOf(const std::vector<Point2>& points) {
  std::vector<gtl::point_data<int>> corners;
  corners.reserve(points.size());
  for (const Point2& p : points) {
    corners.emplace_back(static_cast<int>(std::lround(p.x / kUnit)), static_cast<int>(std::lround(p.y / kUnit)));
  }
  Ring ring;
  gtl::set_points(ring, corners.begin(), corners.end());
  return ring;
}

// Returns the corners (m) of a polygon of Boost, without corners that coincide because of rounding.
template <class Polygon>
std::vector<Point2> pointsOf(const Polygon& polygon) {
  std::vector<Point2> points;
  for (auto p = gtl::begin_points(polygon); p != gtl::end_points(polygon); ++p) {
    const Point2 corner{kUnit * gtl::x(*p), kUnit * gtl::y(*p)};
    if (!points.empty() && std::hypot(corner.x - points.back().x, corner.y - points.back().y) < kUnit / 2) continue;
    points.push_back(corner);
  }
  if (points.size() > 1 && std::hypot(points.front().x - points.back().x, points.front().y - points.back().y) < kUnit) {
    points.pop_back();
  }
  return points;
}

class BlockMaker {
 public:
  // Draws materials and sizes in a fixed order. If the block has a height, the storeys' height is computed from it.
  BlockMaker(Shape& shape, std::uint64_t seed, const Block& block)
      : b_(block), draw_(seed, Kind::Block, block.number), s_(shape) {
    constexpr double kLeastStorey = 2.3, kShedHeight = 2.2;  // m
    constexpr double kAboveCeiling = 0.4;                    // m between the top ceiling and the top of the walls
    const bool shed = block.floors == 0;
    const bool hangs = block.base > 0;
    const char* wall = wallMaterial(draw_.chance(0.4), draw_);
    constexpr double kHighestWood = 4;  // m
    if (shed && block.height < kHighestWood && draw_.chance(0.4)) wall = "wood";
    look_ = facadeLook(s_, wall, draw_);
    look_.foundation = hangs ? block.base : kBelowSlopes;
    base_ = shed ? 0 : draw_.in(0.1, 0.4);
    if (hangs) base_ = block.base;
    storey_ = draw_.in(2.8, 3.3);
    if (block.height > 0 && !shed) {
      storey_ = std::max(kLeastStorey, (block.height - base_ - kAboveCeiling) / block.floors);
    }
    look_.top = !shed ? base_ + storey_ * block.floors + kAboveCeiling : block.height > 0 ? block.height : kShedHeight;
    windowWidth_ = draw_.in(1, 1.6);
    windowHeight_ = std::min(draw_.in(1.3, 1.7), storey_ - 1.1);
    spacing_ = windowWidth_ + draw_.in(0.8, 1.8);
    plan_.insert(ringOf(block.outline));
    for (const std::vector<Point2>& court : block.courts) plan_.insert(ringOf(court), true);
  }

  void make() {
    const Point2* const doorWall = b_.door && b_.base <= 0 ? nearestWall() : nullptr;
    forSides(b_.outline, [&](const Point2& a, const Point2& b) { wall(a, b, &a == doorWall); });
    for (const std::vector<Point2>& court : b_.courts) {
      forSides(court, [&](const Point2& a, const Point2& b) { wall(a, b, false); });
    }
    slab(look_.trim, look_.top - (hasParapet() ? 0.35 : 0.02));
    if (b_.rise > 0) pitchedRoof();
    if (b_.base > 0) slab(look_.trim, b_.base + 0.01);
    for (int floor = 0; floor < b_.floors; ++floor) slab(look_.wood, base_ + floor * storey_ + 0.02);
    if (b_.floors > 0) innerWalls();
  }

 private:
  bool hasParapet() const { return b_.floors > 0 && b_.parapet && b_.rise <= 0; }

  // Returns the first corner (in the outline) of the wall nearest to the entrance, among walls at least 2 m wide.
  const Point2* nearestWall() const {
    const Point2* nearest = b_.outline.data();
    double leastDistance = 1e18;
    forSides(b_.outline, [&](const Point2& a, const Point2& b) {
      const double distance = std::hypot((a.x + b.x) / 2 - b_.entrance.x, (a.y + b.y) / 2 - b_.entrance.y);
      if (std::hypot(b.x - a.x, b.y - a.y) < 2 || distance >= leastDistance) return;
      leastDistance = distance;
      nearest = &a;
    });
    return nearest;
  }

  // Adds the wall from `a` to `b` and the coping of its parapet, if any. Seen from `a`, the building is at the left.
  void wall(const Point2& a, const Point2& b, bool door) {
    const bool open = walls_++ < b_.openWalls;
    const double width = std::hypot(b.x - a.x, b.y - a.y);
    const Vec3d along{(b.x - a.x) / width, (b.y - a.y) / width, 0};
    const Affine frame{{along, {0, 0, 1}, {along.y, -along.x, 0}}, {a.x, a.y, 0}};
    addFacade(s_, look_, frame, width, open ? openings(width, door) : std::vector<Opening>(), draw_);
    if (!hasParapet()) return;
    s_.boxAt(look_.metal, frame * at({width / 2, look_.top, 0}), {width + 0.05, 0.05, 0.3});
  }

  // Adds the faces between the walls and the ridge. Vertical faces, the gables, have the surface of the walls.
  void pitchedRoof() {
    const auto nearestRidgeEnd = [&](const Point2& p) -> const Point2& {
      const auto distance = [&](const Point2& end) { return std::hypot(p.x - end.x, p.y - end.y); };
      return distance(b_.ridge[1]) < distance(b_.ridge[0]) ? b_.ridge[1] : b_.ridge[0];
    };
    forSides(b_.outline, [&](const Point2& p, const Point2& q) {
      const Point2& endP = nearestRidgeEnd(p);
      const Point2& endQ = nearestRidgeEnd(q);
      const Vec3d a{p.x, p.y, look_.top};
      const Vec3d b{q.x, q.y, look_.top};
      const Vec3d c{endQ.x, endQ.y, look_.top + b_.rise};
      const Vec3d d{endP.x, endP.y, look_.top + b_.rise};
      const Vec3d normal = cross(b - a, c - a);
      const SurfaceIndex surface = std::abs(normal.z) < 0.05 * length(normal) ? look_.wall : look_.tile;
      s_.triangle(surface, a, b, c);
      if (&endP != &endQ) s_.triangle(surface, a, c, d);
    });
  }

  // Returns the openings of a wall: a door if `door` is true and, except for sheds, a row of windows in each storey.
  std::vector<Opening> openings(double width, bool door) {
    std::vector<Opening> openings;
    if (b_.floors == 0) {
      if (door && width > 1.6) openings.push_back({{width / 2 - 0.5, width / 2 + 0.5}, {0.02, 2.02}, Opening::Door});
      return openings;
    }
    const int columns = static_cast<int>((width - 0.5) / spacing_);
    if (columns < 1) return openings;
    const double pitch = width / columns;
    for (int floor = 0; floor < b_.floors; ++floor) {
      const double z = base_ + floor * storey_;
      for (int column = 0; column < columns; ++column) {
        const double u = (column + 0.5) * pitch;
        if (door && floor == 0 && column == columns / 2) {
          openings.push_back({{u - 0.55, u + 0.55}, {z - 0.05, z + 2.1}, Opening::Door});
        } else if (b_.shop && floor == 0 && b_.base <= 0) {
          const double half = pitch / 2 - 0.2;
          openings.push_back({{u - half, u + half}, {z + 0.25, z + 2.3}, Opening::Window});
        } else {
          constexpr double kSill = 0.85;  // m above the floor
          const double half = windowWidth_ / 2;
          openings.push_back({{u - half, u + half}, {z + kSill, z + kSill + windowHeight_}, Opening::Window});
        }
      }
    }
    return openings;
  }

  // Adds a horizontal face over the plan at the height z.
  void slab(SurfaceIndex surface, double z) {
    std::vector<Ring> pieces;
    plan_.get_trapezoids(pieces);
    for (const Ring& piece : pieces) {
      const std::vector<Point2> corners = pointsOf(piece);
      for (std::size_t i = 2; i < corners.size(); ++i) {
        s_.triangle(surface, {corners[0].x, corners[0].y, z}, {corners[i - 1].x, corners[i - 1].y, z},
                    {corners[i].x, corners[i].y, z});
      }
    }
  }

  // Adds the rear walls of the rooms, kRoomDepth behind the outer walls.
  void innerWalls() {
    Region core = plan_;
    core.shrink(static_cast<unsigned>(kRoomDepth / kUnit));
    // At spikes of the outline, shrink() returns corners far outside the outline.
    using namespace gtl::operators;
    if (const Region outside = core - plan_; !gtl::empty(outside)) core &= plan_;
    std::vector<gtl::polygon_with_holes_data<int>> parts;
    core.get(parts);
    const auto addWalls = [&](const std::vector<Point2>& corners) {
      forSides(corners, [&](const Point2& a, const Point2& b) {
        s_.quad(look_.wall, {a.x, a.y, base_}, {b.x, b.y, base_}, {b.x, b.y, look_.top - 0.4},
                {a.x, a.y, look_.top - 0.4});
      });
    };
    for (const auto& part : parts) {
      addWalls(pointsOf(part));
      for (auto hole = gtl::begin_holes(part); hole != gtl::end_holes(part); ++hole) addWalls(pointsOf(*hole));
    }
  }

  const Block& b_;
  Draw draw_;
  Shape& s_;
  FacadeLook look_;
  Region plan_;
  std::size_t walls_ = 0;  // number of walls so far
  double base_ = 0, storey_ = 3, windowWidth_ = 1.2, windowHeight_ = 1.4, spacing_ = 2.6;
};

}  // namespace

Model makeBlock(SceneBuilder& builder, std::uint64_t seed, const Block& block) {
  Shape shape(builder, "block");
  if (block.parts.empty()) BlockMaker(shape, seed, block).make();
  for (const Block& part : block.parts) BlockMaker(shape, seed, part).make();
  return shape.finish();
}

}  // namespace scanmill::models
