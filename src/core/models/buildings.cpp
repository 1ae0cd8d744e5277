// Builds houses: walls with openings, windows and doors set back in them, roofs with eaves, chimneys, balconies.

#include <algorithm>
#include <cmath>

#include "models/facade.h"

namespace scanmill::models {
namespace {

constexpr double kStorey = 2.9;  // m, height of a storey

// Returns the material of a plastered facade: mostly "plaster_tinted", for coloured and weathered facades. The choice
// has its own random stream, so that the shapes of houses do not depend on it.
const char* facadeOf(std::uint64_t seed, const House& house) {
  return Draw(seed, Kind::Facade, house.number).chance(0.7) ? "plaster_tinted" : "plaster";
}

constexpr double kThickness = 0.16;  // m, thickness of pitched roofs
constexpr double kHipEaves = 0.45;   // m that hip roofs extend beyond the walls
constexpr double kInRoof = 0.05;     // m that walls extend into hip roofs

class HouseMaker {
 public:
  HouseMaker(SceneBuilder& builder, std::uint64_t seed, const House& house)
      : h_(house), seed_(seed), draw_(seed, Kind::House, house.number), s_(builder, "house") {
    const char* const wall = draw_.chance(0.45) ? "brick" : facadeOf(seed, house);
    look_ = facadeLook(s_, wall, draw_.chance(0.5) ? "wood" : "painted_metal");
    m_.storey = draw_.around(kStorey, 0.06);
    m_.base = draw_.in(0.15, 0.5);
    look_.top = m_.base + m_.storey * h_.floors + (h_.roof == Roof::Flat ? 0.5 : 0.1);
    m_.windowWidth = std::min(draw_.in(0.9, 1.5), h_.width / h_.columns - 0.5);
    m_.windowHeight = draw_.in(1.2, 1.6);
    m_.sill = draw_.in(0.75, 0.95);
    pitch_ = std::tan(radians(draw_.in(30, 46)));
    look_.shutters = !h_.shop && draw_.chance(0.3) && h_.width / h_.columns > m_.windowWidth * 2 + 0.2;
    balconies_ = h_.floors >= 3 && draw_.chance(0.7);
    if (h_.top) reach(*h_.top);
  }

  Model make() {
    walls();
    plinth();
    switch (h_.roof) {
      case Roof::Flat:
        flatRoof();
        break;
      case Roof::Gable:
        gableRoof(Mat3{}, {0, 0, 0}, h_.width, h_.depth);
        break;
      case Roof::CrossGable:
        gableRoof({{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {h_.width, 0, 0}, h_.depth, h_.width);
        break;
      case Roof::Hip:
        hipRoof();
        break;
    }
    downpipes();
    addHouseDetails(s_, seed_, h_, look_, m_);
    return s_.finish();
  }

 private:
  // Adapts the house to the given height of its top (m). A storey is at least kLeastStorey high. If the house would
  // then be too high, the slope of the roof is reduced, to no less than 6 degrees.
  void reach(double top) {
    constexpr double kLeastStorey = 2.3;  // m, least height of a storey
    const double shorter = std::min(h_.width, h_.depth);
    const bool flat = h_.roof == Roof::Flat;
    const double span = flat                          ? 0
                        : h_.roof == Roof::Gable      ? h_.depth / 2
                        : h_.roof == Roof::CrossGable ? h_.width / 2
                                                      : shorter / 2 + kHipEaves;
    const double slab = flat ? 0 : h_.roof == Roof::Hip ? kThickness - kInRoof : kThickness;
    const double above = flat ? 0.5 : 0.1;  // m between the ceiling of the top floor and the top of the walls
    const double room = top - slab - above - m_.base - kLeastStorey * h_.floors;
    const double least = std::tan(radians(6.0));
    if (!flat) pitch_ = std::clamp(room / span, least, h_.rise ? std::max(least, *h_.rise / span) : pitch_);
    m_.storey = std::max(kLeastStorey, (top - slab - span * pitch_ - above - m_.base) / h_.floors);
    look_.top = m_.base + m_.storey * h_.floors + above;
    m_.windowHeight = std::min(m_.windowHeight, m_.storey - m_.sill - 0.3);
  }

  void walls() {
    const std::vector<Opening> front = windows(h_.columns, h_.width, true);
    addFacade(s_, look_, {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {0, 0, 0}}, h_.width, front, true);
    const int back = std::max(2, h_.columns - draw_.below(2));
    addFacade(s_, look_, {{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}, {h_.width, h_.depth, 0}}, h_.width,
              windows(back, h_.width, false), false);
    const int sides = std::max(1, static_cast<int>(h_.depth / 4));
    addFacade(s_, look_, {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {h_.width, 0, 0}}, h_.depth,
              windows(sides, h_.depth, false), false);
    addFacade(s_, look_, {{{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}}, {0, h_.depth, 0}}, h_.depth,
              windows(sides, h_.depth, false), false);
  }

  std::vector<Opening> windows(int columns, double width, bool front) {
    std::vector<Opening> openings;
    const double pitch = width / columns;
    for (int floor = 0; floor < h_.floors; ++floor) {
      const double z = m_.base + floor * m_.storey;
      for (int c = 0; c < columns; ++c) {
        const double u = (c + 0.5) * pitch;
        if (front && floor == 0 && c == h_.doorColumn) {
          openings.push_back({{u - 0.55, u + 0.55}, {m_.base - 0.1, m_.base + 2.1}, Opening::Door});
        } else if (front && floor == 0 && h_.shop) {
          const double half = pitch / 2 - 0.22;
          openings.push_back({{u - half, u + half}, {m_.base + 0.25, m_.base + 2.45}, Opening::Window});
        } else if (front && floor > 0 && balconies_ && c == h_.doorColumn) {
          openings.push_back({{u - 0.6, u + 0.6}, {z + 0.1, z + 2.2}, Opening::Window});
          balcony(u, z);
        } else if (front || draw_.chance(0.85)) {
          const double half = m_.windowWidth / 2;
          openings.push_back({{u - half, u + half}, {z + m_.sill, z + m_.sill + m_.windowHeight}, Opening::Window});
        }
      }
    }
    return openings;
  }

  void balcony(double u, double z) {
    const double width = 2.2;
    const double out = 1.2;
    s_.box(look_.trim, {u, -out / 2 + 0.05, z}, {width, out + 0.1, 0.16});
    const double rail = z + 1.05;
    const double y = -out + 0.06;
    const double x0 = u - width / 2 + 0.06;
    const double x1 = u + width / 2 - 0.06;
    s_.pipe(look_.metal, {{x0, 0.02, rail}, {x0, y, rail}, {x1, y, rail}, {x1, 0.02, rail}},
            {0.025, 0.025, 0.025, 0.025}, 6);
    for (int k = 0; k <= 14; ++k) {
      const double x = lerp(x0, x1, k / 14.0);
      s_.tube(look_.metal, {x, y, z}, {x, y, rail}, 0.01, 0.01, 4);
    }
    for (const double x : {x0, x1}) {
      for (int k = 1; k < 7; ++k) {
        const double at = lerp(0.0, y, k / 7.0);
        s_.tube(look_.metal, {x, at, z}, {x, at, rail}, 0.01, 0.01, 4);
      }
    }
  }

  // Adds a plinth that protrudes 3 cm from the walls.
  void plinth() {
    const double z = (m_.base - 0.12 + look_.foundation) / 2;
    const double height = m_.base - 0.12 - look_.foundation;
    if (height < 0.5 - 0.12) return;
    const double door = h_.doorX();
    const double left = door - 0.75 + 0.03;
    const double right = h_.width + 0.03 - door - 0.75;
    if (left > 0.1) s_.box(look_.trim, {left / 2 - 0.03, 0.02, z}, {left, 0.1, height});
    if (right > 0.1) s_.box(look_.trim, {h_.width + 0.03 - right / 2, 0.02, z}, {right, 0.1, height});
    s_.box(look_.trim, {h_.width / 2, h_.depth - 0.02, z}, {h_.width + 0.06, 0.1, height});
    for (const double x : {0.02, h_.width - 0.02})
      s_.box(look_.trim, {x, h_.depth / 2, z}, {0.1, h_.depth - 0.14, height});
  }

  void flatRoof() {
    const double z = look_.top - 0.35;
    s_.quad(look_.trim, {0, 0, z}, {h_.width, 0, z}, {h_.width, h_.depth, z}, {0, h_.depth, z});
    // Adds the inner side of the parapet and its coping.
    const double t = 0.2;
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
    s_.tube(look_.metal, {w - 1.2, d - 1.5, z - 0.1}, {w - 1.2, d - 1.5, z + 1.2}, 0.15, 0.15, 10);
  }

  // Adds a flat slab of a roof. Its corners are counter-clockwise as seen from outside: a and b at the eaves, c and d
  // at the ridge. The side at the ridge is hidden and left out.
  void slab(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, double thickness) {
    const Vec3d down{0, 0, -thickness};
    s_.quad(look_.tile, a, b, c, d);
    s_.quad(look_.tile, a + down, d + down, c + down, b + down);
    s_.quad(look_.tile, a + down, b + down, b, a);
    s_.quad(look_.tile, b + down, c + down, c, b);
    s_.quad(look_.tile, d + down, a + down, a, d);
  }

  // Adds a gable roof over a plan of width x depth; the ridge is along x of the given frame.
  void gableRoof(const Mat3& turn, const Vec3d& origin, double width, double depth) {
    const Affine outer = s_.frame;
    s_.frame = outer * Affine{turn, origin};
    constexpr double kEaves = 0.4;
    constexpr double kRake = 0.3;
    const double ridge = look_.top + depth / 2 * pitch_;
    s_.triangle(look_.wall, {0, depth, look_.top}, {0, 0, look_.top}, {0, depth / 2, ridge});
    s_.triangle(look_.wall, {width, 0, look_.top}, {width, depth, look_.top}, {width, depth / 2, ridge});
    const double top = ridge + kThickness;
    const double eaves = look_.top - kEaves * pitch_ + kThickness;
    const double x0 = -kRake;
    const double x1 = width + kRake;
    slab({x0, -kEaves, eaves}, {x1, -kEaves, eaves}, {x1, depth / 2, top}, {x0, depth / 2, top}, kThickness);
    slab({x1, depth + kEaves, eaves}, {x0, depth + kEaves, eaves}, {x0, depth / 2, top}, {x1, depth / 2, top},
         kThickness);
    s_.tube(look_.tile, {x0 - 0.02, depth / 2, top}, {x1 + 0.02, depth / 2, top}, 0.1, 0.1, 8);
    for (const double y : {-kEaves - 0.06, depth + kEaves + 0.06}) {
      s_.tube(look_.metal, {x0, y, eaves - 0.1}, {x1, y, eaves - 0.1}, 0.06, 0.06, 8);
    }
    skylights(width, depth, eaves, kEaves);
    chimney(draw_.in(0.15, 0.85) * width, depth * draw_.in(0.35, 0.65), ridge);
    s_.frame = outer;
  }

  void skylights(double width, double depth, double eaves, double overhang) {
    const int count = draw_.below(4);
    const double slope = std::atan(pitch_);
    for (int k = 0; k < count; ++k) {
      const double x = width * (k + 0.5) / count;
      const double y = depth * 0.25;
      const double z = eaves + (y + overhang) * pitch_;
      const Affine lying{{{1, 0, 0}, {0, std::cos(slope), std::sin(slope)}, {0, -std::sin(slope), std::cos(slope)}},
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

  void hipRoof() {
    constexpr double kEaves = kHipEaves;
    const double w = h_.width;
    const double d = h_.depth;
    const double low = look_.top - kInRoof;
    const double eaves = low + kThickness;
    const double short_ = std::min(w, d) / 2 + kEaves;
    const double top = eaves + short_ * pitch_;
    const double x0 = -kEaves;
    const double x1 = w + kEaves;
    const double y0 = -kEaves;
    const double y1 = d + kEaves;
    const Vec3d a = w >= d ? Vec3d{x0 + short_, d / 2, top} : Vec3d{w / 2, y0 + short_, top};
    const Vec3d b = w >= d ? Vec3d{x1 - short_, d / 2, top} : Vec3d{w / 2, y1 - short_, top};
    const std::array<Vec3d, 4> corner{Vec3d{x0, y0, eaves}, {x1, y0, eaves}, {x1, y1, eaves}, {x0, y1, eaves}};
    const Vec3d down{0, 0, -kThickness};
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3d& p = corner[k];
      const Vec3d& q = corner[(k + 1) % 4];
      s_.quad(look_.tile, p + down, q + down, q, p);
    }
    s_.quad(look_.trim, corner[0] + down, corner[3] + down, corner[2] + down, corner[1] + down);
    // Each corner leads to the end of the ridge that is nearest to it.
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
      s_.tube(look_.metal, {x, -0.07, look_.foundation}, {x, -0.07, top}, 0.045, 0.045, 8);
    }
  }

  const House& h_;
  std::uint64_t seed_;
  Draw draw_;
  Shape s_;
  FacadeLook look_;
  HouseMeasures m_;
  double pitch_ = 0;
  bool balconies_ = false;
};

}  // namespace

House drawHouse(Draw& draw, std::uint32_t number, double width, double depth, int floors) {
  House house;
  house.number = number;
  house.width = width;
  house.depth = depth;
  house.floors = floors;
  house.columns = std::max(2, static_cast<int>(width / draw.in(2.2, 3.1)));
  house.doorColumn = draw.below(house.columns);
  house.roof = draw.of(std::array{Roof::Gable, Roof::Gable, Roof::CrossGable, Roof::Hip, Roof::Hip, Roof::Flat});
  if (floors >= 4) house.roof = draw.chance(0.5) ? Roof::Flat : Roof::Gable;
  return house;
}

Model makeHouse(SceneBuilder& builder, std::uint64_t seed, const House& house) {
  return HouseMaker(builder, seed, house).make();
}

}  // namespace scanmill::models
