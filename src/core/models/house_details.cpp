// Builds the interior and the details of a house: rooms, bands, bays, porches, awnings, ivy, garages.

#include <algorithm>
#include <array>
#include <cmath>

#include "models/facade.h"

namespace scanmill::models {
namespace {

constexpr double kWall = 0.25;  // m, thickness of the outer walls

// Adds the details of one house. Sizes (m) are by eye.
class Details {
 public:
  Details(Shape& shape, std::uint64_t seed, const House& house, const FacadeLook& look, const HouseMeasures& measures)
      : s_(shape), h_(house), look_(look), m_(measures), draw_(seed, Kind::HouseDetails, house.number) {}

  void add() {
    rooms();
    if (draw_.chance(0.5)) courses();
    if (draw_.chance(0.5)) cornerStones();
    if (h_.shop) {
      awning();
    } else if (h_.forecourt > 1.6 && draw_.chance(0.4)) {
      bay();
    }
    if (h_.forecourt > 2.4 && !h_.shop && draw_.chance(0.4)) porch();
    if (h_.ivy) ivy();
    fittings();
    if (h_.garage) garage();
  }

 private:
  double pitch() const { return h_.width / h_.columns; }
  double windowMiddle(int column) const { return (column + 0.5) * pitch(); }
  double floorHeight(int floor) const { return m_.base + floor * m_.storey; }

  // Adds floors, and in each storey a partition parallel to the front, partitions between windows, and furniture.
  void rooms() {
    const auto [inside, boards] = s_.surfaces("building", "plaster", "wood");
    const double x0 = kWall;
    const double x1 = h_.width - kWall;
    const double y0 = kWall;
    const double y1 = h_.depth - kWall;
    const auto addFloor = [&](SurfaceIndex surface, double z) {
      s_.quad(surface, {x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z});
    };
    for (int floor = 0; floor < h_.floors; ++floor) addFloor(boards, floorHeight(floor));
    if (h_.roof != Roof::Flat) addFloor(inside, look_.top - 0.05);
    for (int floor = 0; floor < h_.floors; ++floor) {
      const double z0 = floorHeight(floor) + 0.01;
      const double z1 = std::min(z0 + m_.storey - 0.02, look_.top - 0.06);
      const double y = h_.depth * draw_.in(0.35, 0.6);
      s_.quad(inside, {x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1});
      for (int column = 1; column < h_.columns; ++column) {
        if (h_.shop && floor == 0) continue;
        const double x = column * pitch();
        if (draw_.chance(0.6)) s_.quad(inside, {x, y0, z0}, {x, y1, z0}, {x, y1, z1}, {x, y0, z1});
      }
      for (int column = 0; column < h_.columns; ++column) {
        const Vec3d size{draw_.in(0.5, 1.4), draw_.in(0.4, 0.8), draw_.in(0.5, 1.9)};
        s_.box(boards, {windowMiddle(column), draw_.in(1.2, std::max(1.3, y - 0.6)), z0 + size.z / 2}, size);
      }
    }
  }

  // Adds bands around the house: a band below each upper floor, and a band that protrudes farther under the eaves.
  void courses() {
    const double bandDepth = draw_.in(0.05, 0.12);
    const double height = draw_.in(0.12, 0.3);
    for (int floor = 1; floor <= h_.floors; ++floor) {
      const bool eaves = floor == h_.floors;
      const double z = floorHeight(floor) - (eaves ? 0.1 : 0.05) - height / 2;
      const double depth = eaves ? 1.5 * bandDepth : bandDepth;
      for (const double y : {-depth / 2, h_.depth + depth / 2}) {
        s_.box(look_.trim, {h_.width / 2, y, z}, {h_.width + 2 * depth, depth, height});
      }
      for (const bool left : {true, false}) {
        if (left ? h_.partyLeft : h_.partyRight) continue;
        s_.box(look_.trim, {left ? -depth / 2 : h_.width + depth / 2, h_.depth / 2, z}, {depth, h_.depth, height});
      }
    }
  }

  // Adds alternately long and short stones at the two front corners, from the ground floor to the eaves.
  void cornerStones() {
    const double out = draw_.in(0.03, 0.08);  // m beyond the walls
    const double height = draw_.in(0.25, 0.45);
    const int count = static_cast<int>((look_.top - m_.base - 0.4) / height);
    for (int k = 0; k < count; ++k) {
      const double length = k % 2 == 0 ? 0.55 : 0.32;
      const double z = m_.base + 0.02 + (k + 0.5) * height;
      for (const double x : {length / 2 - out, h_.width + out - length / 2}) {
        s_.box(look_.trim, {x, length / 2 - out, z}, {length, length, height - 0.03});
      }
    }
  }

  static constexpr double kBayRoofBelow = 0.3;  // m from the lower edge of a bay's roof to the next floor

  // Adds a bay's wall between two points of the bay's plan. The wall has a window between two piers in each storey.
  void bayWall(const Point2& a, const Point2& b, int floors) {
    const auto at = [&](double t, double z) { return Vec3d{lerp(a.x, b.x, t), lerp(a.y, b.y, t), z}; };
    const auto panel = [&](SurfaceIndex surface, double t0, double t1, double z0, double z1) {
      s_.quad(surface, at(t0, z0), at(t1, z0), at(t1, z1), at(t0, z1));
    };
    for (int floor = 0; floor < floors; ++floor) {
      const double z0 = floor == 0 ? look_.foundation : floorHeight(floor);
      const double z1 = floorHeight(floor + 1) - (floor + 1 == floors ? kBayRoofBelow : 0);
      const double low = floorHeight(floor) + m_.sill;  // m, heights of the window's edges
      const double high = low + m_.windowHeight;
      constexpr double pier = 0.12;  // width of a pier divided by the width of the wall
      panel(look_.wall, 0, 1, z0, low);
      panel(look_.wall, 0, 1, high, z1);
      panel(look_.wall, 0, pier, low, high);
      panel(look_.wall, 1 - pier, 1, low, high);
      panel(look_.glass, pier, 1 - pier, low, high);
      const Vec3d middle = at(0.5, (low + high) / 2);
      s_.rod(look_.wood, {middle.x, middle.y, low}, {middle.x, middle.y, high}, 0.035, 4);
    }
  }

  // Adds a bay with a roof in front of a random column of windows without the door. The bay has one or all storeys.
  void bay() {
    const int column = (h_.doorColumn + 1 + draw_.below(h_.columns - 1)) % h_.columns;
    const double middle = windowMiddle(column);
    const double half = std::min(pitch() / 2 - 0.08, m_.windowWidth / 2 + 0.6);
    const double out = std::min(draw_.in(0.5, 1.1), h_.forecourt - 0.5);
    const double splay = draw_.chance(0.5) ? std::min(0.45, half / 2) : 0.0;
    const int floors = draw_.chance(0.5) ? 1 : h_.floors;
    // Corners of the bay's plan from left to right; the side walls are oblique if `splay` is not 0.
    const std::array<Point2, 4> plan{Point2{middle - half, 0}, Point2{middle - half + splay, -out},
                                     Point2{middle + half - splay, -out}, Point2{middle + half, 0}};
    for (std::size_t k = 0; k < 3; ++k) bayWall(plan[k], plan[k + 1], floors);
    std::vector<Point2> eaves;
    eaves.reserve(plan.size());
    for (const Point2& p : plan) eaves.push_back({1.06 * (p.x - middle), p.y < 0 ? p.y - 0.08 : p.y});
    s_.prism(look_.tile, look_.trim, at({middle, 0, floorHeight(floors) - kBayRoofBelow}), eaves, 0.14);
  }

  // Adds a porch in front of the door: two posts, a beam and a gable roof.
  void porch() {
    const double out = std::min(draw_.in(1.2, 1.9), h_.forecourt - 0.8);
    const double top = m_.base + 2.45;
    const double x = h_.doorX();
    const double half = draw_.in(0.85, 1.2);
    for (const double side : {-1.0, 1.0}) {
      s_.box(look_.wood, {x + side * (half - 0.06), -out + 0.06, (top + look_.foundation) / 2},
             {0.12, 0.12, top - look_.foundation});
      s_.quad(look_.tile, {x, -out - 0.2, top + 0.55}, {x + side * (half + 0.2), -out - 0.2, top},
              {x + side * (half + 0.2), 0, top}, {x, 0, top + 0.55});
    }
    s_.box(look_.wood, {x, -out + 0.06, top - 0.06}, {2 * half - 0.02, 0.1, 0.12});
  }

  // Adds leaves of ivy up to 0.35 m in front of the front wall, from the ground upwards. Windows and door stay free.
  void ivy() {
    const SurfaceIndex leaf = s_.surface("vegetation", "leaf");
    constexpr double kLeavesPerArea = 70;  // 1/m^2
    const double leftX = draw_.in(0, 0.6) * h_.width;
    const double rightX = std::min(h_.width, leftX + draw_.in(1.5, 5));
    const double top = draw_.in(0.4, 0.95) * look_.top;
    const double depth = draw_.in(0.12, 0.35);
    const int count = static_cast<int>((rightX - leftX) * top * kLeavesPerArea);
    for (int k = 0; k < count; ++k) {
      const double x = draw_.in(leftX, rightX);
      // Height and depth of the ivy vary along the wall.
      const double ragged = 0.5 + 0.5 * std::sin(5 * x) * std::sin(2.3 * x + 1);
      const double z = top * std::sqrt(draw_.next()) * (0.6 + 0.4 * ragged);
      const double y = -depth * std::sqrt(draw_.next()) * (0.4 + 0.6 * ragged);
      if (inOpening(x, z)) continue;
      const Vec3d p{x, y, z};
      const Vec3d u = draw_.direction() * draw_.in(0.04, 0.08);
      const Vec3d v = normalized(cross(u, draw_.direction())) * draw_.in(0.04, 0.08);
      s_.quad(leaf, p - u - v, p + u - v, p + u + v, p - u + v);
    }
  }

  // True if a point of the front wall is in a window or in the door.
  bool inOpening(double x, double z) const {
    const int column = std::clamp(static_cast<int>(x / pitch()), 0, h_.columns - 1);
    if (std::abs(x - windowMiddle(column)) > m_.windowWidth / 2) return false;
    const double aboveGround = z - m_.base;  // m above the ground floor
    if (aboveGround < 0) return false;
    if (column == h_.doorColumn && aboveGround < 2.3) return true;
    const double aboveFloor = std::fmod(aboveGround, m_.storey);
    return aboveFloor > m_.sill && aboveFloor < m_.sill + m_.windowHeight;
  }

  // Adds the name board of a shop, and in many cases an awning (a slanted cloth on a frame) and a protruding sign.
  void awning() {
    const SurfaceIndex cloth = s_.surface("building", "cloth");
    const double z = m_.base + 2.55;
    s_.box(look_.metal, {h_.width / 2, -0.09, z + 0.2}, {h_.width - 0.8, 0.14, 0.4});
    if (draw_.chance(0.5)) {
      const double side = draw_.chance(0.5) ? 0.35 : h_.width - 0.35;
      const double tall = draw_.in(0.4, 1.1);
      s_.rod(look_.metal, {side, 0.02, z + 0.75}, {side, -0.85, z + 0.75}, 0.015, 6);
      s_.box(look_.metal, {side, -0.5, z + 0.7 - tall / 2 + 0.35}, {0.08, 0.6, tall});
    }
    const double out = std::min(draw_.in(0.8, 1.4), 1.3);
    if (!draw_.chance(0.6)) return;
    const double low = z - 0.45;
    s_.quad(cloth, {0.4, -out, low}, {h_.width - 0.4, -out, low}, {h_.width - 0.4, -0.05, z}, {0.4, -0.05, z});
    s_.quad(cloth, {0.4, -out, low - 0.2}, {h_.width - 0.4, -out, low - 0.2}, {h_.width - 0.4, -out, low},
            {0.4, -out, low});
    for (const double x : {0.45, h_.width - 0.45}) s_.rod(look_.metal, {x, -0.02, low}, {x, -out, low}, 0.02, 6);
  }

  // Adds a lamp at the door, a meter box, and sometimes a satellite dish or an air conditioner.
  void fittings() {
    const double door = h_.doorX();
    s_.ball(look_.metal, {door + 0.75, -0.12, m_.base + 1.9}, {0.09, 0.1, 0.14}, 8);
    const double pierX = (h_.doorColumn + (h_.doorColumn + 1 < h_.columns ? 1 : 0)) * pitch();  // between two windows
    s_.box(look_.metal, {pierX, -0.06, m_.base + draw_.in(0.4, 1)}, {0.5, 0.14, 0.6});
    for (int floor = 1; floor < h_.floors; ++floor) {
      if (!draw_.chance(0.4)) continue;
      const int column = 1 + draw_.below(h_.columns - 1);
      const double z = floorHeight(floor) + draw_.in(0.4, 1.4);
      if (draw_.chance(0.5)) {
        s_.box(look_.metal, {column * pitch(), -0.2, z}, {0.7, 0.3, 0.55});
      } else {
        s_.ball(look_.metal, {column * pitch(), -0.35, z}, {0.3, 0.08, 0.3}, 10);
        s_.rod(look_.metal, {column * pitch(), 0, z - 0.2}, {column * pitch(), -0.3, z}, 0.02, 6);
      }
    }
  }

  // Adds a garage at the right of the house (seen from the street), kGarageFrom behind the front of the house.
  void garage() {
    constexpr double kWallFoot = -1.5;   // m, lower edge of the walls, low enough for sloping ground
    constexpr double kGateHeight = 2.1;  // m
    const double x0 = h_.width + kGarageBeside;
    const double x1 = x0 + kGarageWidth;
    const double y0 = kGarageFrom;
    const double y1 = y0 + kGarageDepth;
    const double top = draw_.in(2.4, 2.9);
    const auto wall = [&](const Point2& a, const Point2& b, double low, double high) {
      s_.quad(look_.wall, {a.x, a.y, low}, {b.x, b.y, low}, {b.x, b.y, high}, {a.x, a.y, high});
    };
    wall({x1, y0}, {x1, y1}, kWallFoot, top);
    wall({x1, y1}, {x0, y1}, kWallFoot, top);
    wall({x0, y1}, {x0, y0}, kWallFoot, top);
    for (const double x : {x0 + 0.175, x1 - 0.175}) {
      s_.box(look_.wall, {x, y0 + 0.1, (kGateHeight + kWallFoot) / 2}, {0.35, 0.2, kGateHeight - kWallFoot});
    }
    const double middle = (x0 + x1) / 2;
    s_.box(look_.wall, {middle, y0 + 0.1, (kGateHeight + top) / 2}, {x1 - x0, 0.2, top - kGateHeight});
    const double gate = draw_.chance(0.15) ? 1.9 : 0.0;  // m, lower edge of the gate; 1.9: almost open
    s_.quad(look_.metal, {x0 + 0.3, y0 + 0.15, gate}, {x1 - 0.3, y0 + 0.15, gate}, {x1 - 0.3, y0 + 0.15, 2.12},
            {x0 + 0.3, y0 + 0.15, 2.12});
    for (int k = 1; k < 6 && gate == 0; ++k) {
      s_.box(look_.metal, {middle, y0 + 0.14, 0.35 * k}, {x1 - x0 - 0.75, 0.04, 0.05});
    }
    if (draw_.chance(0.5)) {  // a flat roof
      s_.box(look_.trim, {middle, (y0 + y1) / 2, top + 0.08}, {x1 - x0 + 0.3, y1 - y0 + 0.3, 0.16});
      return;
    }
    const double ridge = top + (x1 - x0) * draw_.in(0.25, 0.4);
    for (const double x : {x0 - 0.2, x1 + 0.2}) {
      s_.quad(look_.tile, {x, y0 - 0.2, top - 0.05}, {middle, y0 - 0.2, ridge}, {middle, y1 + 0.2, ridge},
              {x, y1 + 0.2, top - 0.05});
    }
    for (const double y : {y0 + 0.02, y1 - 0.02})
      s_.triangle(look_.wall, {x0, y, top}, {x1, y, top}, {middle, y, ridge});
  }

  Shape& s_;
  const House& h_;
  const FacadeLook& look_;
  const HouseMeasures& m_;
  Draw draw_;
};

}  // namespace

void addHouseDetails(Shape& shape, std::uint64_t seed, const House& house, const FacadeLook& look,
                     const HouseMeasures& measures) {
  Details(shape, seed, house, look, measures).add();
}

}  // namespace scanmill::models
