// Builds street furniture, fences, and objects of roadworks, gardens and squares. Bases extend a little below z = 0.

#include <algorithm>
#include <array>

#include "models/facade.h"
#include "models/models.h"

namespace scanmill::models {
namespace {

constexpr double kSunk = 0.06;  // m, depth to which posts and bases extend below the ground

// Each function below appends one object about the origin. Sizes (m) are by eye from usual products.

void appendBench(Shape& s, Draw&) {
  const auto [wood, metal] = s.surfaces("object", "wood", "painted_metal");
  for (int k = 0; k < 4; ++k) s.box(wood, {0, -0.17 + 0.115 * k, 0.45}, {1.7, 0.095, 0.035});         // seat
  for (int k = 0; k < 3; ++k) s.box(wood, {0, 0.25 + 0.025 * k, 0.58 + 0.13 * k}, {1.7, 0.03, 0.1});  // back
  for (const double x : {-0.7, 0.7}) {  // legs, the supports of seat and back, and an armrest
    for (const double y : {-0.17, 0.2}) s.box(metal, {x, y, (0.43 - kSunk) / 2}, {0.05, 0.05, 0.43 + kSunk});
    s.box(metal, {x, 0.02, 0.415}, {0.045, 0.44, 0.035});
    s.tube(metal, {x, 0.22, 0.42}, {x, 0.32, 0.92}, 0.022, 0.018, 6);
    s.pipe(metal, {{x, -0.18, 0.42}, {x, -0.2, 0.66}, {x, 0.24, 0.66}}, 0.016, 6);
  }
}

void appendHydrant(Shape& s, Draw&) {
  const SurfaceIndex paint = s.surface("object", "painted_metal");
  const std::vector<Point2> body{{0.17, -kSunk}, {0.17, 0.05}, {0.12, 0.06}, {0.11, 0.5},  {0.15, 0.52}, {0.15, 0.57},
                                 {0.11, 0.6},    {0.1, 0.67},  {0.05, 0.74}, {0.03, 0.75}, {0.03, 0.8},  {0, 0.8}};
  s.revolve(paint, {}, body, 16);
  for (const double side : {-1.0, 1.0}) {  // outlets with caps
    s.rod(paint, {0, side * 0.08, 0.42}, {0, side * 0.17, 0.42}, 0.05, 10);
    s.tube(paint, {0, side * 0.16, 0.42}, {0, side * 0.2, 0.42}, 0.06, 0.04, 6);
  }
  s.rod(paint, {0.08, 0, 0.36}, {0.19, 0, 0.36}, 0.065, 10);
}

void appendWheelieBin(Shape& s, Draw&) {
  const auto [body, rubber] = s.surfaces("object", "plastic_black", "rubber");
  s.grid({levelRectangle(0.03, 0.01, 0.01), levelRectangle(0.03, 0.2, 0.2), levelRectangle(0.95, 0.28, 0.27),
          levelRectangle(0.96, 0.31, 0.29), levelRectangle(1.0, 0.31, 0.29), levelRectangle(1.06, 0.22, 0.2, -0.02),
          levelRectangle(1.065, 0.01, 0.01, -0.02)},
         Loop::Closed, body);
  s.rod(body, {-0.33, -0.24, 0.98}, {-0.33, 0.24, 0.98}, 0.018, 8);
  for (const double y : {-0.23, 0.23}) s.rod(rubber, {-0.22, y - 0.03, 0.1}, {-0.22, y + 0.03, 0.1}, 0.1, 14);
  s.rod(body, {-0.22, -0.22, 0.1}, {-0.22, 0.22, 0.1}, 0.015, 6);
}

void appendBin(Shape& s, Draw&) {
  const auto [metal, dark] = s.surfaces("object", "painted_metal", "plastic_black");
  s.rod(metal, {-0.16, 0, -kSunk}, {-0.16, 0, 1.15}, 0.03, 8);
  s.revolve(metal, at({0.05, 0, 0.45}), {{0, 0}, {0.15, 0}, {0.18, 0.5}, {0.19, 0.52}, {0.17, 0.53}}, 16);
  s.revolve(dark, at({0.05, 0, 0.45}), {{0.17, 0.53}, {0.16, 0.4}, {0, 0.4}}, 16);
  s.revolve(metal, at({0.05, 0, 1.08}), {{0, 0}, {0.2, 0}, {0.2, 0.02}, {0.12, 0.1}, {0, 0.13}}, 16);
  for (const double y : {-0.12, 0.12}) s.rod(metal, {0.05, y, 0.93}, {0.05, y, 1.1}, 0.01, 5);
}

void appendLetterBox(Shape& s, Draw&) {
  const auto [paint, dark] = s.surfaces("object", "painted_metal", "plastic_black");
  for (const double y : {-0.15, 0.15}) s.box(paint, {0, y, 0.3}, {0.06, 0.06, 0.6 + kSunk * 2});
  const auto ring = [](double z, double half) { return levelRectangle(z, half * 0.7, half); };
  s.grid({ring(0.58, 0.01), ring(0.58, 0.3), ring(1.2, 0.3), ring(1.3, 0.25), ring(1.34, 0.15), ring(1.345, 0.01)},
         Loop::Closed, paint);
  s.box(dark, {0.21, 0, 1.1}, {0.04, 0.4, 0.05});  // slot
  s.box(paint, {0.212, 0, 0.85}, {0.012, 0.35, 0.25});
}

void appendPowerBox(Shape& s, Draw& draw) {
  const auto [paint, concrete] = s.surfaces("object", "painted_metal", "concrete");
  const double width = draw.in(0.8, 1.4);
  const double height = draw.in(1.0, 1.4);
  s.box(concrete, {0, 0, 0.03}, {width + 0.06, 0.42, 0.2});
  s.box(paint, {0, 0, 0.1 + height / 2}, {width, 0.36, height});
  s.box(paint, {0, 0, 0.12 + height}, {width + 0.08, 0.44, 0.05});
  for (const double side : {-1.0, 1.0}) {  // doors with handles
    s.box(paint, {side * width / 4, -0.18, 0.12 + height / 2}, {width / 2 - 0.05, 0.02, height - 0.12});
    s.box(paint, {side * 0.05, -0.195, 0.2 + height / 2}, {0.03, 0.03, 0.12});
  }
}

void appendBicycleRack(Shape& s, Draw&) {
  const SurfaceIndex metal = s.surface("object", "metal_galvanised");
  for (const double x : {-0.8, 0.0, 0.8}) {
    s.pipe(metal,
           {{x, -0.35, -kSunk}, {x, -0.35, 0.7}, {x, -0.25, 0.8}, {x, 0.25, 0.8}, {x, 0.35, 0.7}, {x, 0.35, -kSunk}},
           0.024, 10);
  }
}

void appendBollard(Shape& s, Draw&) {
  s.revolve(s.surface("object", "painted_metal"), {},
            {{0.06, -kSunk}, {0.06, 0.8}, {0.075, 0.82}, {0.075, 0.88}, {0.06, 0.94}, {0, 0.97}}, 14);
}

void appendPlanter(Shape& s, Draw&) {
  const auto [concrete, soil] = s.surfaces("object", "concrete", "soil");
  s.revolve(concrete, {}, {{0.32, -kSunk}, {0.35, 0.1}, {0.48, 0.5}, {0.5, 0.55}, {0.44, 0.55}, {0.43, 0.5}}, 20);
  s.revolve(soil, {}, {{0.43, 0.5}, {0.2, 0.53}, {0, 0.54}}, 20);
}

constexpr double kHalfPanel = 1;  // m, half of the length of a fence panel

void appendPicketsFence(Shape& s, Draw& draw) {
  const SurfaceIndex wood = s.surface("fence", draw.chance(0.6) ? "wood_weathered" : "wood_painted");
  const double h = draw.in(0.85, 1.1);
  for (const double z : {0.25, h - 0.25}) s.box(wood, {0, 0.035, z}, {2 * kHalfPanel, 0.05, 0.09});
  s.box(wood, {-kHalfPanel + 0.06, 0.12, (h - kSunk) / 2}, {0.12, 0.12, h + kSunk + 0.1});
  constexpr int kPickets = 15;
  for (int k = 0; k < kPickets; ++k) {
    const double x = -kHalfPanel + 2 * kHalfPanel * (k + 0.5) / kPickets;
    s.prism(wood, wood, sideView({x, 0, 0}), {{-0.04, 0.06}, {0.04, 0.06}, {0.04, h - 0.06}, {0, h}, {-0.04, h - 0.06}},
            0.02);
  }
}

void appendBarsFence(Shape& s, Draw& draw) {
  const SurfaceIndex metal = s.surface("fence", "painted_metal");
  const double h = draw.in(1.0, 1.4);
  constexpr double kBase = 0.4;  // m, height of the wall below the bars
  const SurfaceIndex brick = s.surface("fence", draw.chance(0.6) ? "brick" : "brick_light");
  s.box(brick, {0, 0, (kBase - kSunk) / 2}, {2 * kHalfPanel, 0.24, kBase + kSunk});
  s.box(brick, {-kHalfPanel + 0.18, 0, (h - kSunk) / 2}, {0.36, 0.36, h + kSunk + 0.1});
  for (const double z : {kBase + 0.1, h - 0.12}) s.box(metal, {0, 0, z}, {2 * kHalfPanel, 0.02, 0.04});
  constexpr int kBars = 17;
  for (int k = 1; k < kBars; ++k) {
    const double x = -kHalfPanel + 2 * kHalfPanel * k / kBars;
    s.pipe(metal, {{x, 0, kBase}, {x, 0, h - 0.05}, {x, 0, h + 0.05}}, {0.01, 0.01, 0.002}, 5);
  }
}

void appendWall(Shape& s, Draw& draw) {
  const double h = draw.in(0.7, 1.8);
  const auto [brick, concrete] = s.surfaces("wall", wallMaterial(draw.chance(0.6), draw), "concrete");
  s.box(brick, {0, 0, (h - 0.2) / 2}, {2 * kHalfPanel, 0.24, h + 0.2});
  s.box(brick, {-kHalfPanel + 0.18, 0, (h - 0.1) / 2}, {0.36, 0.36, h + 0.3});  // pier
  s.box(brick, {0, 0, 0.05}, {2 * kHalfPanel, 0.3, 0.5});                       // plinth
  s.box(concrete, {0, 0, h + 0.03}, {2 * kHalfPanel, 0.32, 0.07});
}

// Appends a fence of boards on both sides of two rails by turns, with gaps between the boards of a side.
void appendBoardsFence(Shape& s, Draw& draw) {
  const SurfaceIndex wood = s.surface("fence", draw.chance(0.6) ? "wood_weathered" : "wood_painted");
  const double h = draw.in(1.2, 1.9);
  for (const double z : {0.25, h - 0.25}) s.box(wood, {0, 0, z}, {2 * kHalfPanel, 0.06, 0.09});
  s.box(wood, {-kHalfPanel + 0.06, 0, (h - kSunk) / 2}, {0.12, 0.12, h + kSunk + 0.1});
  constexpr int kBoards = 12;
  for (int k = 0; k < kBoards; ++k) {
    const double x = -kHalfPanel + 2 * kHalfPanel * (k + 0.5) / kBoards;
    s.box(wood, {x, k % 2 == 0 ? 0.05 : -0.05, h / 2},
          {2 * kHalfPanel / kBoards + 0.01, 0.02, h + draw.in(-0.03, 0.03)});
  }
}

// Appends a chain-link fence: wires 3 mm thick in two directions, 0.1 m apart. Most of a laser beam passes through.
void appendWireFence(Shape& s, Draw& draw) {
  const SurfaceIndex metal = s.surface("fence", "metal_weathered");
  const double h = draw.in(1.1, 2.0);
  const SurfaceIndex concrete = s.surface("fence", "concrete");
  s.box(concrete, {-kHalfPanel + 0.05, 0, (h - kSunk) / 2}, {0.1, 0.1, h + kSunk + 0.1});
  s.box(concrete, {0, 0, 0.07}, {2 * kHalfPanel, 0.05, 0.3});  // gravel board
  for (const double z : {0.25, h / 2, h}) s.rod(metal, {-kHalfPanel, 0, z}, {kHalfPanel, 0, z}, 0.003, 4);
  for (const double side : {-1.0, 1.0}) {  // wires that rise towards +x, and towards -x
    for (const double footX : steps(-kHalfPanel - h, kHalfPanel, 0.1)) {
      const double low = std::max(footX, -kHalfPanel);
      const double high = std::min(footX + h, kHalfPanel);
      if (high - low < 0.02) continue;
      const Vec3d a{side * low, 0, low - footX + 0.02};
      const Vec3d b{side * high, 0, high - footX + 0.02};
      const Vec3d across{side * 0.0011, 0, -0.0011};
      s.quad(metal, a - across, b - across, b + across, a + across);
    }
  }
}

// Appends a guard rail, as along motorways: a steel beam with a W-shaped profile on posts.
void appendGuardRail(Shape& s, Draw& /*draw*/) {
  const SurfaceIndex metal = s.surface("fence", "metal_weathered");
  s.box(metal, {-kHalfPanel + 0.06, 0.06, 0.25}, {0.06, 0.1, 0.8});
  const std::vector<Point2> profile{{0.44, 0},     {0.48, -0.08}, {0.54, -0.08}, {0.6, -0.02},
                                    {0.66, -0.08}, {0.72, -0.08}, {0.76, 0}};  // z and y (m)
  for (std::size_t k = 1; k < profile.size(); ++k) {
    const auto corner = [&](double x, const Point2& p) { return Vec3d{x, p.y, p.x}; };
    s.quad(metal, corner(-kHalfPanel, profile[k - 1]), corner(kHalfPanel, profile[k - 1]),
           corner(kHalfPanel, profile[k]), corner(-kHalfPanel, profile[k]));
  }
}

// Appends a concrete safety barrier, wider at its foot.
void appendBarrierPanel(Shape& s, Draw& /*draw*/) {
  const SurfaceIndex concrete = s.surface("fence", "concrete");
  const Affine across{{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {-kHalfPanel, 0, 0}};
  const std::vector<Point2> profile{{-0.28, -0.1}, {0.28, -0.1},  {0.28, 0.12}, {0.14, 0.3},
                                    {0.09, 0.85},  {-0.09, 0.85}, {-0.14, 0.3}, {-0.28, 0.12}};
  s.prism(concrete, concrete, across, profile, 2 * kHalfPanel);
}

// The functions that append a piece of furniture, in the order of Furnishing.
constexpr std::array<void (*)(Shape&, Draw&), static_cast<std::size_t>(Furnishing::Count)> kAppendFurniture{
    appendBin,      appendWheelieBin,  appendHydrant, appendBench,  appendLetterBox,
    appendPowerBox, appendBicycleRack, appendBollard, appendPlanter};

constexpr double kClutterSunk = 0.05;  // m that bases extend below the ground

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
  s.grid({levelRectangle(0.05, 0.01, 0.01), levelRectangle(0.05, 1, 0.75), levelRectangle(height, 1.7, 0.85)},
         Loop::Closed, metal);
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
  s.grid(rows, Loop::Closed, sand);
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

// Appends a basin with a stone rim: a pond, or a fountain with a column in the middle.
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

// Appends a pile of logs along y. The logs of a row lie in the gaps between the logs of the row below.
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

// The functions that append clutter, in the order of Clutter.
constexpr std::array<void (*)(Shape&, Draw&), static_cast<std::size_t>(Clutter::Count)> kAppendClutter{
    appendCone, appendBarrier,      appendSkip,        appendPallets, appendHeap,
    appendShed, appendBasin<false>, appendBasin<true>, appendSwing,   appendWoodPile};

}  // namespace

Model makeFurnishing(SceneBuilder& builder, std::uint64_t seed, Furnishing kind) {
  Draw draw(seed, Kind::Furniture, static_cast<int>(kind));
  Shape s(builder, "furniture");
  kAppendFurniture[static_cast<std::size_t>(kind)](s, draw);
  return s.finish();
}

Model makeShelter(SceneBuilder& builder, std::uint64_t seed) {
  Draw draw(seed, Kind::Shelter);
  Shape s(builder, "bus shelter");
  const auto [metal, glass, wood] = s.surfaces("structure", "painted_metal", "glass", "wood");
  const double width = draw.in(3.2, 4.2);
  const double height = draw.in(2.35, 2.55);
  constexpr double kDepth = 1.3;
  for (const double x : {-width / 2, 0.0, width / 2}) {
    s.box(metal, {x, kDepth / 2, height / 2 - 0.03}, {0.08, 0.08, height});  // rear posts
  }
  for (const double x : {-width / 2, width / 2}) {  // front posts, and side walls of glass
    s.box(metal, {x, -kDepth / 2 + 0.1, height / 2 - 0.03}, {0.07, 0.07, height});
    s.box(glass, {x, 0.05, 1.25}, {0.02, kDepth - 0.3, 1.9});
  }
  for (const double x : {-width / 4, width / 4}) s.box(glass, {x, kDepth / 2, 1.25}, {width / 2 - 0.1, 0.02, 1.9});
  s.box(metal, {0, 0.0, height + 0.03}, {width + 0.4, kDepth + 0.4, 0.12});                                    // roof
  for (int k = 0; k < 3; ++k) s.box(wood, {0, kDepth / 2 - 0.42 + 0.12 * k, 0.47}, {width * 0.7, 0.1, 0.04});  // seat
  for (const double x : {-width * 0.3, width * 0.3}) s.box(metal, {x, kDepth / 2 - 0.3, 0.2}, {0.06, 0.3, 0.5});
  return s.finish();
}

Model makeFencePanel(SceneBuilder& builder, std::uint64_t seed, Fencing kind, int form) {
  constexpr int kKinds = static_cast<int>(Fencing::Count);
  // In the order of Fencing. Fencing::None has no panels, and makeHedgerow() builds hedges: these entries are not used.
  constexpr std::array<void (*)(Shape&, Draw&), kKinds> kPanels{
      appendWall,        appendPicketsFence, appendBarsFence, appendWall,        appendWall,
      appendBoardsFence, appendWireFence,    appendGuardRail, appendBarrierPanel};
  Draw draw(seed, Kind::Boundary, form * kKinds + static_cast<int>(kind));
  Shape s(builder, kind == Fencing::Brick ? "garden wall" : "fence");
  kPanels[static_cast<std::size_t>(kind)](s, draw);
  return s.finish();
}

Model makeClutter(SceneBuilder& builder, std::uint64_t seed, Clutter clutter, int number) {
  // Skips the number 3, which is no longer used, so that the clutter of existing seeds stays the same.
  const int kind = static_cast<int>(clutter) + (clutter > Clutter::Skip ? 1 : 0);
  Draw draw(seed, Kind::Clutter, kind * 100 + number);
  Shape s(builder, "clutter");
  kAppendClutter[static_cast<std::size_t>(clutter)](s, draw);
  return s.finish();
}

}  // namespace scanmill::models
