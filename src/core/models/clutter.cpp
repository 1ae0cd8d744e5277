// Objects of roadworks, gardens and squares.

#include <array>

#include "models/models.h"

namespace scanmill::models {
namespace {

constexpr double kClutterSunk = 0.05;  // m that bases extend below the ground

// The functions below append one object each, about the origin. Its sizes (m) are by eye from usual products.

// Appends a traffic cone on a square foot, with two reflecting bands.
void appendCone(Shape& s, Draw& draw) {
  const auto [body, band] = s.surfaces("object", "plastic_black", "sign_retroreflective");
  const double height = draw.in(0.45, 0.8);
  const double halfFoot = 0.42 * height;
  s.box(body, {0, 0, 0.02}, {2 * halfFoot, 2 * halfFoot, 0.04});
  const auto radius = [&](double t) { return lerp(0.34, 0.07, t) * height; };
  // Appends the part between two heights, which are fractions of the cone's height.
  const auto appendRing = [&](SurfaceIndex surface, double low, double high) {
    s.revolve(surface, {}, {{radius(low), low * height}, {radius(high), high * height}}, 14);
  };
  appendRing(body, 0.03, 0.4);
  appendRing(band, 0.4, 0.6);
  appendRing(body, 0.6, 0.7);
  appendRing(band, 0.7, 0.85);
  appendRing(body, 0.85, 1);
}

void appendBarrier(Shape& s, Draw&) {
  const auto [post, board] = s.surfaces("object", "metal_galvanised", "sign_retroreflective");
  for (const double x : {-0.9, 0.9}) {
    s.rod(post, {x, 0, 0}, {x, 0, 1.1}, 0.025, 8);
    s.box(post, {x, 0, 0.04}, {0.08, 0.7, 0.08});
  }
  for (const double z : {0.3, 0.95}) s.box(board, {0, 0, z}, {2, 0.03, 0.22});
}

// Appends a container full of rubble.
void appendSkip(Shape& s, Draw& draw) {
  const auto [metal, rubble] = s.surfaces("object", "painted_metal", "soil");
  const double height = draw.in(1.0, 1.4);
  s.grid({levelRectangle(0.05, 0.01, 0.01), levelRectangle(0.05, 1, 0.75), levelRectangle(height, 1.7, 0.85)}, true,
         [&](int, int) { return metal; });
  for (const double y : {-0.87, 0.87}) s.box(metal, {0, y, height}, {3.4, 0.06, 0.08});
  s.ball(rubble, {0, 0, height - 0.25}, {1.5, 0.75, 0.45}, 14);
}

void appendPallets(Shape& s, Draw& draw) {
  const SurfaceIndex wood = s.surface("object", "wood_weathered");
  const int count = 2 + draw.below(6);
  for (int k = 0; k < count; ++k) {
    const double z = 0.145 * k;
    for (int board = 0; board < 5; ++board) s.box(wood, {0, -0.35 + 0.175 * board, z + 0.13}, {1.2, 0.1, 0.022});
    for (const double x : {-0.55, 0.0, 0.55}) s.box(wood, {x, 0, z + 0.06}, {0.1, 0.8, 0.11});
  }
}

// Appends a heap of sand: a cone with an uneven surface.
void appendHeap(Shape& s, Draw& draw) {
  const SurfaceIndex sand = s.surface("object", "soil");
  const double radius = draw.in(0.9, 1.8);
  std::vector<std::vector<Vec3d>> rows;
  for (int ring = 0; ring <= 6; ++ring) {
    const double t = ring / 6.0;  // 0 at the foot, 1 at the top
    std::vector<Vec3d>& row = rows.emplace_back();
    for (const Point2& p : regularPolygon(20, 1)) {
      const double r = radius * (1 - t) * (ring == 0 ? 1 : draw.around(1, 0.1));
      row.push_back({r * p.x, r * p.y, ring == 0 ? -kClutterSunk : 0.55 * radius * t});
    }
  }
  s.grid(rows, true, [&](int, int) { return sand; });
}

// Appends a garden shed: boarded walls, a gable roof whose ridge is along x, and a door.
void appendShed(Shape& s, Draw& draw) {
  const auto [wood, roof] = s.surfaces("structure", "wood_weathered", "roof_tile");
  const double x = draw.in(1.0, 1.7);  // m, half of the length and of the width
  const double y = draw.in(0.9, 1.4);
  const double top = draw.in(1.9, 2.2);
  const int boards = static_cast<int>(2 * x / 0.16);
  s.box(wood, {0, 0, top / 2 - 0.2}, {2 * x - 0.04, 2 * y - 0.04, top + 0.4});
  for (int k = 0; k < boards; ++k) {  // boards in front of the wall, with gaps between them
    const double boardX = -x + (k + 0.5) * 2 * x / boards;
    for (const double side : {-y, y}) s.box(wood, {boardX, side, top / 2 - 0.2}, {0.11, 0.03, top + 0.4});
  }
  const double ridge = top + y * 0.5;
  for (const double side : {-1.0, 1.0}) {
    s.quad(roof, {-x - 0.15, side * (y + 0.15), top - 0.07}, {x + 0.15, side * (y + 0.15), top - 0.07},
           {x + 0.15, 0, ridge}, {-x - 0.15, 0, ridge});
    s.triangle(wood, {side * (x - 0.02), -y, top}, {side * (x - 0.02), y, top}, {side * (x - 0.02), 0, ridge - 0.06});
  }
  s.box(wood, {0, -y - 0.02, 0.85}, {0.8, 0.04, 1.7});
}

// Appends a pond, or a fountain with a column in its middle: a basin with a stone rim.
template <bool Fountain>
void appendBasin(Shape& s, Draw& draw) {
  const SurfaceIndex stone = s.surface(Fountain ? "structure" : "object", "concrete");
  const SurfaceIndex water = s.surface("water", "water");
  const double radius = Fountain ? draw.in(1.4, 2.2) : draw.in(0.9, 1.9);
  const double rim = Fountain ? draw.in(0.45, 0.65) : draw.in(0.12, 0.25);
  s.revolve(stone, {}, {{radius, -0.5}, {radius, rim}, {radius - 0.22, rim}, {radius - 0.22, -0.5}}, 28);
  const double level = rim - 0.07;
  s.revolve(water, {}, {{radius - 0.2, level}, {0, level}}, 28);
  if (!Fountain) return;
  s.revolve(stone, {},
            {{0.3, 0}, {0.22, 0.3}, {0.18, 1.1}, {0.6, 1.3}, {0.62, 1.38}, {0.1, 1.3}, {0.09, 1.8}, {0, 1.85}}, 18);
}

// Appends a frame of wood with two swings, whose seats hang on chains.
void appendSwing(Shape& s, Draw&) {
  const auto [wood, metal] = s.surfaces("object", "wood", "metal_galvanised");
  for (const double x : {-1.3, 1.3}) {
    for (const double y : {-0.9, 0.9}) s.rod(wood, {x, y, -0.1}, {x, 0, 2.2}, 0.06, 8);
  }
  s.rod(wood, {-1.4, 0, 2.2}, {1.4, 0, 2.2}, 0.06, 8);
  for (const double seat : {-0.55, 0.55}) {
    for (const double x : {-0.2, 0.2}) s.rod(metal, {seat + x, 0, 2.2}, {seat + x, 0.1, 0.5}, 0.008, 4);
    s.box(wood, {seat, 0.1, 0.48}, {0.45, 0.18, 0.03});
  }
}

// Appends a pile of logs along y; the logs of a row lie in the gaps between those of the row below.
void appendWoodPile(Shape& s, Draw& draw) {
  const SurfaceIndex bark = s.surface("object", "bark");
  const int rows = 3 + draw.below(5);
  for (int row = 0; row < rows; ++row) {
    for (int k = 0; k < 12 - row % 2; ++k) {
      const double radius = draw.in(0.06, 0.09);
      const double x = -0.95 + 0.165 * k + (row % 2 == 0 ? 0 : 0.08);
      const double z = 0.07 + 0.14 * row;
      const double near = draw.in(-0.22, -0.16);
      const double far = draw.in(0.16, 0.22);
      s.rod(bark, {x, near, z}, {x, far, z}, radius, 7);
    }
  }
}

// The functions that build each kind of clutter, by the values of Clutter.
constexpr std::array<void (*)(Shape&, Draw&), static_cast<std::size_t>(Clutter::Count)> kAppendClutter{
    appendCone, appendBarrier,      appendSkip,        appendPallets, appendHeap,
    appendShed, appendBasin<false>, appendBasin<true>, appendSwing,   appendWoodPile};

}  // namespace

Model makeClutter(SceneBuilder& builder, std::uint64_t seed, Clutter clutter, int number) {
  // The numbers of the draws leave out 3, so that towns keep their shapes.
  const int kind = static_cast<int>(clutter) + (clutter > Clutter::Skip ? 1 : 0);
  Draw draw(seed, Kind::Clutter, kind * 100 + number);
  Shape s(builder, "clutter");
  kAppendClutter[static_cast<std::size_t>(clutter)](s, draw);
  return s.finish();
}

}  // namespace scanmill::models
