// Builds traffic signs, street lamps, traffic lights and utility poles. Posts begin a little below the ground.

#include <array>
#include <cmath>

#include "models/models.h"

namespace scanmill::models {
namespace {

constexpr double kSignSunk = 0.1;  // m that posts extend below the ground

// Returns a frame that turns a drawing in the x, y plane upright and towards +x: its x becomes y, its y becomes z.
Affine facing(const Vec3d& center) {
  return {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, center};
}

std::vector<Point2> rectangle(double width, double height) {
  return {{-width / 2, -height / 2}, {width / 2, -height / 2}, {width / 2, height / 2}, {-width / 2, height / 2}};
}

// The board of a traffic sign: a regular polygon, or a square.
struct SignForm {
  int corners;        // 0: a square
  double radius;      // m, distance of a polygon's corners from its middle
  double firstAngle;  // rad, direction from the middle to one of the corners
  double halfHeight;  // m, upper bound of half the height of the board
};

// The boards in the order of TrafficSign. Sizes are about the sizes of German signs for a speed limit of 50 km/h.
constexpr std::array<SignForm, kSigns> kSignForms{{{24, 0.3, 0, 0.3},
                                                   {3, 0.42, kPi / 2, 0.42},
                                                   {4, 0.36, 0, 0.36},
                                                   {8, 0.38, kPi / 8, 0.36},
                                                   {0, 0, 0, 0.3},
                                                   {3, 0.45, -kPi / 2, 0.45}}};

}  // namespace

// Builds a traffic sign on a post, in some cases with a rectangular plate below the sign.
Model makeSign(SceneBuilder& builder, std::uint64_t seed, TrafficSign sign, int number) {
  Draw draw(seed, Kind::Sign, number);
  Shape s(builder, "traffic sign");
  const SurfaceIndex post = s.surface("pole", "metal_galvanised");
  const auto [front, back] = s.surfaces("traffic_sign", "sign_retroreflective", "painted_metal");
  const double low = draw.in(2.2, 2.5);  // m, height of the board's lower edge
  const auto& [corners, radius, firstAngle, halfHeight] = kSignForms[static_cast<std::size_t>(sign)];
  const std::vector<Point2> board =
      corners == 0 ? rectangle(2 * halfHeight, 2 * halfHeight) : regularPolygon(corners, radius, firstAngle);
  const bool plate = draw.chance(0.4);
  s.rod(post, {0, 0, -kSignSunk}, {0, 0, low + halfHeight * 2 + 0.05}, 0.03, 12);
  const double middle = low + halfHeight;
  s.prism(front, back, facing({0.045, 0, middle}), board, 0.004);
  for (const double dz : {-0.12, 0.12}) s.box(back, {0.015, 0, middle + dz}, {0.06, 0.09, 0.03});  // clamps
  if (plate) {
    s.prism(front, back, facing({0.045, 0, low - 0.2}), rectangle(0.5, 0.22), 0.004);
    s.box(back, {0.015, 0, low - 0.2}, {0.06, 0.09, 0.03});
  }
  return s.finish();
}

// Builds a street lamp. Form 0 has an arm along +x; the other forms have a lantern on top.
Model makeLamp(SceneBuilder& builder, std::uint64_t seed, int form) {
  Draw draw(seed, Kind::Lamp, form);
  Shape s(builder, "street lamp");
  const auto [metal, paint, glass] = s.surfaces("street_lamp", "metal_galvanised", "painted_metal", "glass");
  const double height = form == 0 ? draw.in(6.5, 8.0) : draw.in(4.0, 5.0);
  s.revolve(metal, {}, {{0.1, -kSignSunk}, {0.1, 0.9}, {0.075, 1.0}, {0.05, height - 0.6}}, 14);
  s.box(paint, {0, -0.095, 0.55}, {0.08, 0.02, 0.3});  // the fuse box's door
  if (form == 0) {
    const double reach = draw.in(1.2, 2.0);
    std::vector<Vec3d> arm{{0, 0, height - 0.7}};  // a quarter of a circle from the mast, then straight to `reach`
    std::vector<double> radii{0.05};
    for (int k = 0; k <= 8; ++k) {
      const double angle = kPi / 2 * k / 8;
      arm.push_back({0.6 * (1 - std::cos(angle)), 0, height - 0.6 + 0.6 * std::sin(angle)});
      radii.push_back(lerp(0.05, 0.035, k / 8.0));
    }
    arm.push_back({reach, 0, height + 0.05});
    radii.push_back(0.03);
    s.pipe(metal, arm, radii, 10);
    s.ball(paint, {reach + 0.25, 0, height + 0.06}, {0.38, 0.15, 0.075}, 16);
    s.ball(glass, {reach + 0.28, 0, height + 0.01}, {0.28, 0.12, 0.06}, 14);
  } else {
    s.revolve(paint, at({0, 0, height - 0.6}), {{0.05, -0.02}, {0.07, 0.03}, {0.14, 0.08}, {0.14, 0.1}, {0, 0.1}}, 12);
    s.revolve(glass, at({0, 0, height - 0.5}), {{0.12, 0}, {0.2, 0.36}}, 12);
    s.revolve(paint, at({0, 0, height - 0.14}), {{0, 0}, {0.26, 0}, {0.26, 0.02}, {0.1, 0.12}, {0, 0.16}}, 14);
  }
  return s.finish();
}

UtilityPole makeUtilityPole(SceneBuilder& builder, std::uint64_t seed) {
  Draw draw(seed, Kind::UtilityPole);
  Shape s(builder, "utility pole");
  const auto [wood, metal] = s.surfaces("pole", "wood_weathered", "metal_weathered");
  UtilityPole pole;
  const double height = draw.in(8, 9.5);
  s.tube(wood, {0, 0, -kSignSunk}, {0, 0, height}, 0.16, 0.1, 14);
  const int wires = 2 + draw.below(3);
  const double half = 0.35 + 0.22 * wires;  // m, half of the length of the crossarm
  const double arm = height - 0.35;         // m, height of the crossarm
  s.box(wood, {0.14, 0, arm}, {0.09, 2 * half + 0.2, 0.11});
  for (const double side : {-1.0, 1.0}) {  // braces
    s.rod(metal, {0.14, side * 0.6 * half, arm - 0.05}, {0.1, side * 0.05, arm - 0.6}, 0.015, 6);
  }
  for (int k = 0; k < wires; ++k) {
    const double y = lerp(-half, half, static_cast<double>(k) / (wires - 1));
    s.revolve(metal, at({0.14, y, arm + 0.05}), {{0.012, 0}, {0.05, 0.04}, {0.03, 0.08}, {0.045, 0.12}, {0, 0.15}}, 10);
    pole.insulators.push_back({0.14, y, arm + 0.2});
  }
  pole.telephone = {0.13, 0, height - draw.in(1.5, 2)};
  s.box(metal, {0.12, 0, pole.telephone.z - 0.1}, {0.06, 0.1, 0.14});
  if (draw.chance(0.3)) {  // a transformer
    s.rod(metal, {-0.38, 0, arm - 1.5}, {-0.38, 0, arm - 0.6}, 0.24, 14);
    s.box(metal, {-0.14, 0, arm - 1}, {0.2, 0.12, 0.1});
  }
  pole.model = s.finish();
  return pole;
}

Model makeTrafficLight(SceneBuilder& builder, std::uint64_t seed) {
  Draw draw(seed, Kind::Light);
  Shape s(builder, "traffic light");
  const SurfaceIndex post = s.surface("pole", "metal_weathered");
  const auto [box, glass] = s.surfaces("traffic_light", "plastic_black", "glass");
  const double z = draw.in(2.3, 2.6);  // m, height of the lower edge of the housing
  s.rod(post, {0, 0, -kSignSunk}, {0, 0, z + 1.15}, 0.057, 14);
  s.box(box, {0.19, 0, z + 0.5}, {0.2, 0.3, 0.96});
  s.box(box, {0.1, 0, z + 0.5}, {0.012, 0.46, 1.1});  // backing board
  for (const double dz : {0.12, 0.88}) s.box(box, {0.06, 0, z + dz}, {0.12, 0.06, 0.04});
  for (int k = 0; k < 3; ++k) {
    const double center = z + 0.2 + 0.3 * k;
    s.ball(glass, {0.285, 0, center}, {0.03, 0.1, 0.1}, 16);
    // Adds a visor over the lens: three quarters of a thin tube.
    std::vector<std::vector<Vec3d>> rows;
    for (int i = 0; i <= 12; ++i) {
      const double angle = lerp(1.25 * kPi, -0.25 * kPi, i / 12.0);
      const auto rim = [&](double r, double x) { return Vec3d{x, r * std::cos(angle), center + r * std::sin(angle)}; };
      rows.push_back({rim(0.125, 0.28), rim(0.125, 0.48 - 0.06 * (1 - std::sin(angle))),
                      rim(0.115, 0.48 - 0.06 * (1 - std::sin(angle))), rim(0.115, 0.28)});
    }
    s.grid(rows, Loop::Closed, box);
  }
  // The signal for pedestrians, and the box with the button.
  s.box(box, {0, 0.17, z - 0.15}, {0.22, 0.18, 0.5});
  for (const double dz : {-0.12, 0.12}) s.ball(glass, {0, 0.265, z - 0.15 + dz}, {0.08, 0.02, 0.08}, 12);
  s.box(box, {0, -0.08, 1.05}, {0.09, 0.06, 0.16});
  return s.finish();
}

}  // namespace scanmill::models
