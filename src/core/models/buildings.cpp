// Builds houses: with recessed windows and doors, rooms behind them, pitched or flat roofs, chimneys and balconies.

#include <algorithm>
#include <cmath>

#include "models/facade.h"

namespace scanmill::models {
namespace {

constexpr double kStorey = 2.9;      // m, mean height of a storey
constexpr double kThickness = 0.16;  // m, thickness of pitched roofs
constexpr double kHipEaves = 0.45;   // m, overhang of hip roofs beyond the walls
constexpr double kInRoof = 0.05;     // m, height of the part of a wall inside a hip roof

class HouseMaker {
 public:
  // Draws materials and sizes in a fixed order, then fits the sizes to the height on the map, if there is one.
  HouseMaker(SceneBuilder& builder, std::uint64_t seed, const House& house)
      : h_(house), seed_(seed), draw_(seed, Kind::House, house.number), s_(builder, "house") {
    // The walls' material has its own random stream, so that it does not change the other random values.
    Draw facade(seed, Kind::Facade, house.number);
    look_ = facadeLook(s_, wallMaterial(draw_.chance(0.45), facade), draw_);
    m_.storey = draw_.around(kStorey, 0.06);
    m_.base = draw_.in(0.15, 0.5);
    look_.top = m_.base + m_.storey * h_.floors + aboveCeiling();
    m_.windowWidth = std::min(draw_.in(0.9, 1.5), h_.width / h_.columns - 0.5);
    m_.windowHeight = draw_.in(1.2, 1.6);
    m_.sill = draw_.in(0.75, 0.95);
    slope_ = std::tan(radians(draw_.in(30, 46)));
    look_.shutters = !h_.shop && draw_.chance(0.3) && h_.width / h_.columns > m_.windowWidth * 2 + 0.2;
    balconies_ = h_.floors >= 3 && draw_.chance(0.7);
    if (h_.top) fitHeight(*h_.top);
  }

  Model make() {
    walls();
    plinth();
    if (h_.roof == Roof::Flat) flatRoof();
    if (h_.roof == Roof::Gable) gableRoof(Mat3{}, {0, 0, 0}, h_.width, h_.depth);
    if (h_.roof == Roof::CrossGable)
      gableRoof({{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {h_.width, 0, 0}, h_.depth, h_.width);
    if (h_.roof == Roof::Hip) hipRoof();
    downpipes();
    addHouseDetails(s_, seed_, h_, look_, m_);
    return s_.finish();
  }

 private:
  // Returns the height (m) between the ceiling of the top floor and the top of the walls.
  double aboveCeiling() const { return h_.roof == Roof::Flat ? 0.5 : 0.1; }

  // Returns the horizontal distance (m) over which a pitched roof rises from its eaves to its ridge; 0 for flat roofs.
  double roofRun() const {
    const std::array runs{0.0, h_.depth / 2, h_.width / 2, std::min(h_.width, h_.depth) / 2 + kHipEaves};  // by Roof
    return runs[static_cast<std::size_t>(h_.roof)];
  }

  // Sets the storeys' height, the slope and the top of the walls so that the house is `top` metres high. Storeys are at
  // least kLeastStorey high. If the house would then be too high, the slope is reduced, but not below 6 degrees.
  void fitHeight(double top) {
    constexpr double kLeastStorey = 2.3;  // m
    const double leastSlope = std::tan(radians(6.0));
    const bool flat = h_.roof == Roof::Flat;
    // The height of the roof's tiles above the walls.
    const double tiles = flat ? 0 : h_.roof == Roof::Hip ? kThickness - kInRoof : kThickness;
    const double run = roofRun();
    if (!flat) {
      const double highestRise = top - tiles - aboveCeiling() - m_.base - kLeastStorey * h_.floors;
      slope_ = std::clamp(highestRise / run, leastSlope, h_.rise ? std::max(leastSlope, *h_.rise / run) : slope_);
    }
    m_.storey = std::max(kLeastStorey, (top - tiles - run * slope_ - aboveCeiling() - m_.base) / h_.floors);
    look_.top = m_.base + m_.storey * h_.floors + aboveCeiling();
    m_.windowHeight = std::min(m_.windowHeight, m_.storey - m_.sill - 0.3);
  }

  // Adds the front wall; then the rear wall and the walls at the right and the left, all three without shutters.
  void walls() {
    addFacade(s_, look_, sideView({0, 0, 0}), h_.width, frontOpenings(), draw_);
    FacadeLook look = look_;
    look.shutters = false;
    const int rearColumns = std::max(2, h_.columns - draw_.below(2));
    addFacade(s_, look, {{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}, {h_.width, h_.depth, 0}}, h_.width,
              windows(rearColumns, h_.width), draw_);
    const auto sideColumns = [&](bool party) { return party ? 0 : std::max(1, static_cast<int>(h_.depth / 4)); };
    addFacade(s_, look, {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {h_.width, 0, 0}}, h_.depth,
              windows(sideColumns(h_.partyRight), h_.depth), draw_);
    addFacade(s_, look, {{{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}}, {0, h_.depth, 0}}, h_.depth,
              windows(sideColumns(h_.partyLeft), h_.depth), draw_);
  }

  Opening windowAt(double u, double floorZ) const {
    const double half = m_.windowWidth / 2;
    return {{u - half, u + half}, {floorZ + m_.sill, floorZ + m_.sill + m_.windowHeight}, Opening::Window};
  }

  // Adds balconies. Returns the front wall's openings: the door, windows, shop windows, and the doors to balconies.
  std::vector<Opening> frontOpenings() {
    std::vector<Opening> openings;
    const double pitch = h_.width / h_.columns;
    for (int floor = 0; floor < h_.floors; ++floor) {
      const double z = m_.base + floor * m_.storey;
      for (int column = 0; column < h_.columns; ++column) {
        const double u = (column + 0.5) * pitch;
        if (floor == 0 && column == h_.doorColumn) {
          openings.push_back({{u - 0.55, u + 0.55}, {m_.base - 0.1, m_.base + 2.1}, Opening::Door});
        } else if (floor == 0 && h_.shop) {
          const double half = pitch / 2 - 0.22;
          openings.push_back({{u - half, u + half}, {m_.base + 0.25, m_.base + 2.45}, Opening::Window});
        } else if (floor > 0 && balconies_ && column == h_.doorColumn) {
          openings.push_back({{u - 0.6, u + 0.6}, {z + 0.1, z + 2.2}, Opening::Window});
          balcony(u, z);
        } else {
          openings.push_back(windowAt(u, z));
        }
      }
    }
    return openings;
  }

  // Returns the windows of a wall without a door. At random, 15 % of the windows are left out.
  std::vector<Opening> windows(int columns, double width) {
    std::vector<Opening> openings;
    for (int floor = 0; floor < h_.floors; ++floor) {
      for (int column = 0; column < columns; ++column) {
        if (!draw_.chance(0.85)) continue;
        openings.push_back(windowAt((column + 0.5) * (width / columns), m_.base + floor * m_.storey));
      }
    }
    return openings;
  }

  // Adds a balcony at the front wall: slab, handrail and bars. `u`: position along the wall; `z`: height of the floor.
  void balcony(double u, double z) {
    constexpr double kWidth = 2.2, kOut = 1.2;  // m
    s_.box(look_.trim, {u, -kOut / 2 + 0.05, z}, {kWidth, kOut + 0.1, 0.16});
    const double rail = z + 1.05;
    const double y = -kOut + 0.06;
    const double x0 = u - kWidth / 2 + 0.06;
    const double x1 = u + kWidth / 2 - 0.06;
    s_.pipe(look_.metal, {{x0, 0.02, rail}, {x0, y, rail}, {x1, y, rail}, {x1, 0.02, rail}}, 0.025, 6);
    const auto bar = [&](double barX, double barY) {
      s_.rod(look_.metal, {barX, barY, z}, {barX, barY, rail}, 0.01, 4);
    };
    for (int k = 0; k <= 14; ++k) bar(lerp(x0, x1, k / 14.0), y);
    for (const double x : {x0, x1}) {
      for (int k = 1; k < 7; ++k) bar(x, lerp(0.0, y, k / 7.0));
    }
  }

  // Adds a plinth that protrudes 3 cm from the walls, with a gap at the door, unless it would be lower than 0.38 m.
  void plinth() {
    const double z = (m_.base - 0.12 + look_.foundation) / 2;
    const double height = m_.base - 0.12 - look_.foundation;
    if (height < 0.5 - 0.12) return;
    const double door = h_.doorX();
    const double leftWidth = door - 0.75 + 0.03;
    const double rightWidth = h_.width + 0.03 - door - 0.75;
    if (leftWidth > 0.1) s_.box(look_.trim, {leftWidth / 2 - 0.03, 0.02, z}, {leftWidth, 0.1, height});
    if (rightWidth > 0.1) {
      s_.box(look_.trim, {h_.width + 0.03 - rightWidth / 2, 0.02, z}, {rightWidth, 0.1, height});
    }
    s_.box(look_.trim, {h_.width / 2, h_.depth - 0.02, z}, {h_.width + 0.06, 0.1, height});
    for (const bool left : {true, false}) {
      if (left ? h_.partyLeft : h_.partyRight) continue;
      s_.box(look_.trim, {left ? 0.02 : h_.width - 0.02, h_.depth / 2, z}, {0.1, h_.depth - 0.14, height});
    }
  }

  // Adds the roof, the inner side of the parapet with its coping, a ventilation box and a pipe.
  void flatRoof() {
    const double z = look_.top - 0.35;
    s_.quad(look_.trim, {0, 0, z}, {h_.width, 0, z}, {h_.width, h_.depth, z}, {0, h_.depth, z});
    const double t = 0.2;  // m, thickness of the parapet
    const double w = h_.width;
    const double d = h_.depth;
    s_.quad(look_.wall, {t, t, z}, {t, t, look_.top}, {w - t, t, look_.top}, {w - t, t, z});
    s_.quad(look_.wall, {w - t, d - t, z}, {w - t, d - t, look_.top}, {t, d - t, look_.top}, {t, d - t, z});
    s_.quad(look_.wall, {t, d - t, z}, {t, d - t, look_.top}, {t, t, look_.top}, {t, t, z});
    s_.quad(look_.wall, {w - t, t, z}, {w - t, t, look_.top}, {w - t, d - t, look_.top}, {w - t, d - t, z});
    for (const double y : {t / 2, d - t / 2}) s_.box(look_.metal, {w / 2, y, look_.top}, {w + 0.1, t + 0.1, 0.05});
    for (const double x : {t / 2, w - t / 2})
      s_.box(look_.metal, {x, d / 2, look_.top}, {t + 0.1, d - 2 * t - 0.1, 0.05});
    const double x = draw_.in(2, w - 2);
    s_.box(look_.metal, {x, d / 2, z + 0.5}, {1.6, 1.2, 1.1});
    s_.rod(look_.metal, {w - 1.2, d - 1.5, z - 0.1}, {w - 1.2, d - 1.5, z + 1.2}, 0.15, 10);
  }

  // Adds a slab of a roof; the slab has no face at the ridge. Corners, counter-clockwise as seen from outside: `a` and
  // `b` at the eaves, `c` and `d` at the ridge. `thickness`: m, vertical.
  void slab(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, double thickness) {
    const Vec3d down{0, 0, -thickness};
    s_.quad(look_.tile, a, b, c, d);
    s_.quad(look_.tile, a + down, d + down, c + down, b + down);
    s_.quad(look_.tile, a + down, b + down, b, a);
    s_.quad(look_.tile, b + down, c + down, c, b);
    s_.quad(look_.tile, d + down, a + down, a, d);
  }

  // Adds a gable roof. `rotation`, `origin`: frame of the roof, in which the ridge is along x and `depth` is along y.
  void gableRoof(const Mat3& rotation, const Vec3d& origin, double width, double depth) {
    const Affine outer = s_.frame;
    s_.frame = outer * Affine{rotation, origin};
    constexpr double kEaves = 0.4, kRake = 0.3;  // m, overhang beyond the walls at the eaves and at the gables
    const double ridge = look_.top + depth / 2 * slope_;
    s_.triangle(look_.wall, {0, depth, look_.top}, {0, 0, look_.top}, {0, depth / 2, ridge});
    s_.triangle(look_.wall, {width, 0, look_.top}, {width, depth, look_.top}, {width, depth / 2, ridge});
    const double top = ridge + kThickness;
    const double eaves = look_.top - kEaves * slope_ + kThickness;
    const double x0 = h_.partyLeft ? 0 : -kRake;
    const double x1 = h_.partyRight ? width : width + kRake;
    slab({x0, -kEaves, eaves}, {x1, -kEaves, eaves}, {x1, depth / 2, top}, {x0, depth / 2, top}, kThickness);
    slab({x1, depth + kEaves, eaves}, {x0, depth + kEaves, eaves}, {x0, depth / 2, top}, {x1, depth / 2, top},
         kThickness);
    s_.rod(look_.tile, {x0 - 0.02, depth / 2, top}, {x1 + 0.02, depth / 2, top}, 0.1, 8);
    for (const double y : {-kEaves - 0.06, depth + kEaves + 0.06}) {
      s_.rod(look_.metal, {x0, y, eaves - 0.1}, {x1, y, eaves - 0.1}, 0.06, 8);
    }
    skylights(width, depth, eaves, kEaves);
    chimney(draw_.in(0.15, 0.85) * width, depth * draw_.in(0.35, 0.65), ridge);
    s_.frame = outer;
  }

  // Adds up to three skylights to a gable roof's front slope, whose lower edge is at z = `eaves`, y = -`overhang` (m).
  void skylights(double width, double depth, double eaves, double overhang) {
    const int count = draw_.below(4);
    const double angle = std::atan(slope_);
    for (int k = 0; k < count; ++k) {
      const double x = width * (k + 0.5) / count;
      const double y = depth * 0.25;
      const double z = eaves + (y + overhang) * slope_;
      const Affine lying{{{1, 0, 0}, {0, std::cos(angle), std::sin(angle)}, {0, -std::sin(angle), std::cos(angle)}},
                         {x, y, z}};
      s_.boxAt(look_.metal, lying, {0.9, 1.2, 0.12});
      s_.boxAt(look_.glass, lying * at({0, 0, 0.02}), {0.74, 1.04, 0.11});
    }
  }

  void chimney(double x, double y, double ridge) {
    if (!draw_.chance(0.75)) return;
    const SurfaceIndex brick = s_.surface("building", "brick");
    const double low = look_.top - 0.2;
    const double high = ridge + draw_.in(0.5, 0.9);
    s_.box(brick, {x, y, (low + high) / 2}, {0.7, 0.55, high - low});
    s_.box(look_.trim, {x, y, high}, {0.85, 0.7, 0.1});
    for (const double dx : {-0.16, 0.16}) s_.tube(brick, {x + dx, y, high}, {x + dx, y, high + 0.4}, 0.1, 0.08, 10);
  }

  // Adds a roof whose four slopes are equally steep. Its ridge is along the longer side of the house.
  void hipRoof() {
    const double w = h_.width;
    const double d = h_.depth;
    const double low = look_.top - kInRoof;
    const double eaves = low + kThickness;
    const double run = roofRun();
    const double top = eaves + run * slope_;
    const double x0 = -kHipEaves;
    const double x1 = w + kHipEaves;
    const double y0 = -kHipEaves;
    const double y1 = d + kHipEaves;
    const Vec3d a = w >= d ? Vec3d{x0 + run, d / 2, top} : Vec3d{w / 2, y0 + run, top};  // ends of the ridge
    const Vec3d b = w >= d ? Vec3d{x1 - run, d / 2, top} : Vec3d{w / 2, y1 - run, top};
    const std::array<Vec3d, 4> corner{Vec3d{x0, y0, eaves}, {x1, y0, eaves}, {x1, y1, eaves}, {x0, y1, eaves}};
    const Vec3d down{0, 0, -kThickness};
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3d& p = corner[k];
      const Vec3d& q = corner[(k + 1) % 4];
      s_.quad(look_.tile, p + down, q + down, q, p);
    }
    s_.quad(look_.trim, corner[0] + down, corner[3] + down, corner[2] + down, corner[1] + down);
    // Each corner of the eaves is joined to the nearest end of the ridge.
    const auto endAt = [&](std::size_t k) { return (w >= d ? k % 4 == 1 || k % 4 == 2 : k % 4 >= 2) ? b : a; };
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3d r = endAt(k + 1);
      const Vec3d s = endAt(k);
      s_.triangle(look_.tile, corner[k], corner[(k + 1) % 4], r);
      if (length(r - s) > 0.01) s_.triangle(look_.tile, corner[k], r, s);
    }
    chimney(w * draw_.in(0.35, 0.65), d * 0.4, top);
  }

  void downpipes() {
    const double top = look_.top - 0.1;
    for (const double x : {0.12, h_.width - 0.12}) {
      s_.rod(look_.metal, {x, -0.07, look_.foundation}, {x, -0.07, top}, 0.045, 8);
    }
  }

  const House& h_;
  std::uint64_t seed_;
  Draw draw_;
  Shape s_;
  FacadeLook look_;
  HouseMeasures m_;
  double slope_ = 0;  // m/m, slope of the pitched roof
  bool balconies_ = false;
};

}  // namespace

House drawHouse(Draw& draw, std::uint32_t number, double width, double depth, int floors) {
  House house{.width = width, .depth = depth, .floors = floors, .number = number};
  house.columns = std::max(2, static_cast<int>(width / draw.in(2.2, 3.1)));
  house.doorColumn = draw.below(house.columns);
  house.roof = draw.itemOf(std::array{Roof::Gable, Roof::Gable, Roof::CrossGable, Roof::Hip, Roof::Hip, Roof::Flat});
  if (floors >= 4) house.roof = draw.chance(0.5) ? Roof::Flat : Roof::Gable;
  return house;
}

Model makeHouse(SceneBuilder& builder, std::uint64_t seed, const House& house) {
  return HouseMaker(builder, seed, house).make();
}

}  // namespace scanmill::models
