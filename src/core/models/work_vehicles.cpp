// Builds trailers, caravans, tractors and excavators. x is forward; a hitch is in front. Sizes (m) are by eye.

#include <array>

#include "models/models.h"

namespace scanmill::models {
namespace {

constexpr const char* kClass = "other_vehicle";

// Appends a trailer: a frame with its hitch and a box, sometimes with a cover.
void appendTrailer(Shape& s, Draw& draw) {
  const auto [metal, black, reflector] =
      s.surfaces(kClass, "metal_galvanised", "plastic_black", "sign_retroreflective");
  const double length = draw.in(2.2, 3.2);
  const double width = draw.in(1.3, 1.6);
  const double wall = draw.in(0.35, 0.45);
  const double bed = 0.55;                 // m, height of the floor
  for (const double side : {-1.0, 1.0}) {  // side, end, drawbar, lamp and mudguard
    s.box(metal, {0, side * width / 2, bed + wall / 2}, {length, 0.04, wall});
    s.box(metal, {side * length / 2, 0, bed + wall / 2}, {0.04, width, wall});
    s.rod(black, {length / 2, side * width / 4, bed - 0.05}, {length / 2 + 1.1, 0, bed - 0.1}, 0.04, 6);
    s.box(reflector, {-length / 2 - 0.03, side * (width / 2 - 0.12), bed - 0.05}, {0.04, 0.2, 0.1});
    s.box(black, {0, side * (width / 2 + 0.12), 0.62}, {0.8, 0.22, 0.03});
  }
  s.box(metal, {0, 0, bed}, {length, width, 0.05});
  appendWheels(s, kClass, 0, width / 2 + 0.03, 0.28, 0.16);
  s.rod(black, {length / 2 + 0.7, 0, 0.05}, {length / 2 + 0.7, 0, bed}, 0.03, 8);
  if (draw.chance(0.5)) {  // half of the trailers have a cover
    const SurfaceIndex cover = s.surface(kClass, "cloth");
    s.box(cover, {0, 0, bed + wall + 0.6}, {length - 0.03, width - 0.03, 1.2});
  }
}

// Appends a caravan: its body with windows and a door on the right, wheels, drawbar, support and gas box.
void appendCaravan(Shape& s, Draw& draw) {
  const auto [shell, glass, black] = s.surfaces(kClass, "car_paint_white", "glass", "plastic_black");
  const double length = draw.in(4.2, 6.2);
  const double half = 1.12;  // m, half of the width
  const double top = draw.in(2.5, 2.65);
  // The outline in side view, from the bottom of the front over the roof to the rear.
  const double e = length / 2;
  const std::vector<Point2> side{{e - 0.25, 0.45},      {e, 0.9},       {e - 0.12, 1.5},
                                 {e - 0.5, top - 0.15}, {e - 0.9, top}, {-e + 0.5, top},
                                 {-e + 0.1, top - 0.3}, {-e, 0.9},      {-e + 0.1, 0.45}};
  s.prism(shell, shell, sideView({0, half, 0}), side, 2 * half);
  for (const double y : {-half - 0.01, half + 0.01}) {
    for (const double x : {-0.25 * length, 0.12 * length}) s.box(glass, {x, y, 1.65}, {1.1, 0.03, 0.55});
  }
  s.box(glass, {e - 0.28, 0, 1.75}, {0.12, 1.5, 0.5});
  s.box(shell, {-0.1 * length, -half - 0.02, 1.35}, {0.65, 0.04, 1.7});
  appendWheels(s, kClass, -0.1, half - 0.1, 0.33, 0.2);
  for (const double y : {-0.45, 0.45}) s.rod(black, {e - 0.2, y, 0.5}, {e + 1.2, 0, 0.45}, 0.05, 6);
  s.rod(black, {e + 0.9, 0, 0.05}, {e + 0.9, 0, 0.6}, 0.035, 8);
  s.box(black, {e + 0.35, 0, 0.75}, {0.55, 0.8, 0.45});
}

// Appends a cab with posts and glass on all sides, and a seat in it.
void appendCab(Shape& s, const Vec3d& middle, const Vec3d& size) {
  const auto [paint, glass, seat] = s.surfaces(kClass, "painted_metal", "glass", "cloth_dark");
  s.box(paint, middle + Vec3d{0, 0, size.z / 2}, {size.x + 0.1, size.y + 0.1, 0.1});
  s.box(paint, middle - Vec3d{0, 0, size.z / 2}, {size.x, size.y, 0.1});
  for (const double sign : {-1.0, 1.0}) {
    for (const double ySign : {-1.0, 1.0}) {
      const Vec3d post{sign * size.x / 2, ySign * size.y / 2, 0};
      s.rod(paint, middle + post - Vec3d{0, 0, size.z / 2}, middle + post * 0.95 + Vec3d{0, 0, size.z / 2}, 0.05, 6);
    }
    s.box(glass, middle + Vec3d{sign * size.x / 2, 0, 0}, {0.01, size.y - 0.1, size.z - 0.15});
    s.box(glass, middle + Vec3d{0, sign * size.y / 2, 0}, {size.x - 0.1, 0.01, size.z - 0.15});
  }
  s.box(seat, middle - Vec3d{0.1, 0, 0.3 * size.z}, {0.5, 0.5, 0.15});
  s.box(seat, middle - Vec3d{0.35, 0, 0.05 * size.z}, {0.12, 0.48, 0.6});
}

// Appends a tractor: large rear wheels, small front wheels, bonnet, cab, mudguards, exhaust and lower links.
void appendTractor(Shape& s, Draw& draw) {
  const auto [paint, black] = s.surfaces(kClass, "painted_metal", "plastic_black");
  const double rearRadius = draw.in(0.75, 0.9);
  appendWheels(s, kClass, -0.7, 0.78, rearRadius, 0.45);
  appendWheels(s, kClass, 1.5, 0.72, 0.62 * rearRadius, 0.3);
  s.box(black, {0.4, 0, 0.75}, {2.6, 0.5, 0.35});
  s.box(paint, {1.2, 0, 1.2}, {1.5, 0.72, 0.65});
  s.box(black, {1.97, 0, 1.15}, {0.06, 0.65, 0.5});
  appendCab(s, {-0.35, 0, 1.95}, {1.3, 1.25, 1.5});
  for (const double y : {-0.8, 0.8}) s.box(paint, {-0.7, y, 2 * rearRadius + 0.06}, {1.2, 0.5, 0.05});
  s.rod(black, {0.95, -0.3, 1.5}, {0.95, -0.3, 2.6}, 0.05, 8);
  for (const double y : {-0.3, 0.3}) s.rod(black, {-1.2, y, 0.8}, {-1.75, y, 0.55}, 0.04, 6);
}

// Appends an excavator: two tracks, and on them the upper carriage, rotated at random, with cab, boom, arm and bucket.
void appendExcavator(Shape& s, Draw& draw) {
  const auto [paint, track, metal] = s.surfaces(kClass, "painted_metal", "rubber", "metal_weathered");
  for (const double y : {-0.75, 0.75}) {
    std::vector<Point2> belt = regularPolygon(16, 0.32);  // two half circles about the ends of the track
    for (Point2& p : belt) p.x += p.x > 0 ? 0.95 : -0.95;
    s.prism(track, track, sideView({0, y + 0.2, 0.32}), belt, 0.4);
  }
  s.box(metal, {0, 0, 0.5}, {1.2, 1.2, 0.3});
  s.frame = at({0, 0, 0}, draw.in(-0.6, 0.6));
  s.box(paint, {-0.45, 0, 1.05}, {1.7, 1.7, 0.7});
  s.box(metal, {-1.25, 0, 1.0}, {0.35, 1.6, 0.8});  // counterweight
  appendCab(s, {0.3, 0.45, 1.75}, {1.2, 0.8, 1.4});
  // The boom leads from its foot to the elbow, the arm from there to the wrist, where the bucket hangs.
  const Vec3d foot{0.6, -0.25, 1.2};
  const Vec3d elbow = foot + Vec3d{draw.in(1.2, 1.7), 0, draw.in(1.3, 1.8)};
  const Vec3d wrist = elbow + Vec3d{draw.in(0.5, 1.0), 0, draw.in(-1.9, -1.4)};
  s.tube(paint, foot, elbow, 0.2, 0.15, 4);
  s.tube(paint, elbow, wrist, 0.15, 0.1, 4);
  s.tube(metal, foot + Vec3d{0.3, 0, -0.1}, (foot + elbow) * 0.5 + Vec3d{0.15, 0, 0}, 0.05, 0.04, 8);
  s.tube(metal, (foot + elbow) * 0.5 + Vec3d{0, 0, 0.25}, elbow + Vec3d{0.12, 0, 0.1}, 0.05, 0.04, 8);
  s.prism(metal, metal, sideView(wrist + Vec3d{0, 0.35, 0}), {{-0.35, -0.1}, {-0.2, -0.5}, {0.25, -0.45}, {0.12, 0.08}},
          0.7);
  s.frame = {};
}

// Functions that append the vehicles, in the order of WorkVehicle.
constexpr std::array<void (*)(Shape&, Draw&), static_cast<std::size_t>(WorkVehicle::Count)> kAppend{
    appendTrailer, appendCaravan, appendTractor, appendExcavator};

}  // namespace

Model makeWorkVehicle(SceneBuilder& builder, std::uint64_t seed, WorkVehicle kind, int number) {
  Draw draw(seed, Kind::WorkVehicle, static_cast<int>(kind) * 100 + number);
  Shape s(builder, "other vehicle");
  kAppend[static_cast<std::size_t>(kind)](s, draw);
  return s.finish();
}

}  // namespace scanmill::models
