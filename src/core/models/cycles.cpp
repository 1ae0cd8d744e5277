// Bicycles and motorcycles.

#include <algorithm>
#include <cmath>

#include "models/models.h"

namespace scanmill::models {
namespace {

// Returns a frame that rotates z to y, so that tori and wheels stand upright in a plane of constant y.
Affine upright(const Vec3d& center) {
  return {{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, center};
}

// Appends a thin strip along an arc over a wheel. `from` and `to` are the angles of the arc's ends (rad).
void appendMudguard(Shape& s, SurfaceIndex surface, const Vec3d& hub, double radius, double width, double from,
                    double to) {
  std::vector<std::vector<Vec3d>> rows;
  constexpr int kSteps = 14;
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = lerp(from, to, double(k) / kSteps);
    const auto rim = [&](double r, double y) { return hub + Vec3d{r * std::cos(angle), y, r * std::sin(angle)}; };
    rows.push_back(
        {rim(radius - 0.01, -width / 2), rim(radius, 0), rim(radius - 0.01, width / 2), rim(radius - 0.006, 0)});
  }
  s.grid(rows, true, [&](int, int) { return surface; });
}

void appendBicycleWheel(Shape& s, const Vec3d& hub, double radius) {
  const SurfaceIndex rubber = s.surface("bicycle", "rubber");
  const SurfaceIndex metal = s.surface("bicycle", "metal_bare");
  s.torus(rubber, upright(hub), radius - 0.019, 0.019, 36, 8);
  s.torus(metal, upright(hub), radius - 0.045, 0.011, 36, 6);
  s.tube(metal, hub + Vec3d{0, -0.06, 0}, hub + Vec3d{0, 0.06, 0}, 0.02, 0.02, 8);
  constexpr int kSpokes = 18;
  for (int k = 0; k < kSpokes; ++k) {
    const double angle = 2 * kPi * k / kSpokes;
    const double side = k % 2 == 0 ? 0.03 : -0.03;
    s.tube(metal, hub + Vec3d{0, side, 0},
           hub + Vec3d{(radius - 0.05) * std::cos(angle), 0, (radius - 0.05) * std::sin(angle)}, 0.002, 0.002, 3);
  }
}

// Appends a luggage rack of tubes above the rear wheel, up to `toSeat` (m along x).
void appendRack(Shape& s, SurfaceIndex metal, const Vec3d& rear, double wheelRadius, double toSeat) {
  const double rack = wheelRadius * 2 + 0.06;  // m, height of the rack
  for (const double y : {-0.055, 0.055}) {
    s.tube(metal, {rear.x - 0.2, y, rack}, {toSeat, y, rack}, 0.006, 0.006, 5);
    s.tube(metal, {rear.x - 0.1, y, rack}, {rear.x, y, wheelRadius}, 0.005, 0.005, 5);
  }
  for (const double x : {-0.2, -0.1, 0.0, 0.1}) {
    s.tube(metal, {rear.x + x, -0.055, rack}, {rear.x + x, 0.055, rack}, 0.005, 0.005, 5);
  }
}

// Appends a basket of wires around a point in front of the handlebar.
void appendBasket(Shape& s, SurfaceIndex metal, const Vec3d& center) {
  for (const double z : {-0.12, 0.0, 0.12}) {
    const double w = 0.12 + z * 0.1;
    s.pipe(metal,
           {center + Vec3d{-w, -w * 1.3, z}, center + Vec3d{w, -w * 1.3, z}, center + Vec3d{w, w * 1.3, z},
            center + Vec3d{-w, w * 1.3, z}, center + Vec3d{-w, -w * 1.3, z + 0.003}},
           {0.005, 0.005, 0.005, 0.005, 0.005}, 4);
  }
  for (int k = 0; k < 12; ++k) {
    const double angle = 2 * kPi * k / 12;
    const Vec3d out{std::clamp(std::cos(angle) * 1.4, -1.0, 1.0), std::clamp(std::sin(angle) * 1.4, -1.0, 1.0) * 1.3,
                    0};
    s.tube(metal, center + out * 0.108 + Vec3d{0, 0, -0.12}, center + out * 0.132 + Vec3d{0, 0, 0.12}, 0.003, 0.003, 3);
  }
}

}  // namespace

Model makeBicycle(SceneBuilder& builder, std::uint64_t seed, int form, RiderFit* fit) {
  Draw draw(seed, fit != nullptr ? Kind::RiddenBicycle : Kind::Bicycle, static_cast<std::uint32_t>(form));
  Shape s(builder, "bicycle");
  const SurfaceIndex paint = s.surface("bicycle", "painted_metal");
  const SurfaceIndex metal = s.surface("bicycle", "metal_bare");
  const SurfaceIndex black = s.surface("bicycle", "plastic_black");
  const SurfaceIndex reflector = s.surface("bicycle", "sign_retroreflective");

  const double r = draw.in(0.335, 0.355);
  const double base = draw.in(1.02, 1.12);
  const bool stepThrough = draw.chance(0.5);
  const bool basket = draw.chance(0.4);
  const bool sporty = !stepThrough && draw.chance(0.5);
  const Vec3d rear{-base * 0.47, 0, r};
  const Vec3d front{base * 0.53, 0, r};
  const Vec3d bracket{-0.06, 0, 0.285};
  const double size = draw.in(0.94, 1.06);
  const Vec3d seatTop{-0.22, 0, 0.28 + 0.5 * size};
  const Vec3d saddle{-0.26, 0, 0.28 + 0.66 * size};
  const Vec3d headLow{front.x - 0.13, 0, 0.68};
  const Vec3d headHigh{front.x - 0.18, 0, 0.86};
  const Vec3d bar{front.x - 0.2, 0, sporty ? 0.96 : 1.06};

  appendBicycleWheel(s, rear, r);
  appendBicycleWheel(s, front, r);
  s.tube(paint, bracket, seatTop, 0.016, 0.016, 8);
  s.tube(paint, bracket, headLow, 0.02, 0.02, 8);
  s.tube(paint, stepThrough ? bracket + (seatTop - bracket) * 0.4 : seatTop,
         stepThrough ? headLow + (headHigh - headLow) * 0.4 : headHigh, 0.017, 0.017, 8);
  s.tube(paint, headLow, headHigh, 0.022, 0.022, 8);
  for (const double y : {-0.055, 0.055}) {
    s.tube(paint, bracket + Vec3d{0, y * 0.5, 0}, rear + Vec3d{0, y, 0}, 0.01, 0.008, 6);
    s.tube(paint, seatTop + Vec3d{0, y * 0.3, -0.03}, rear + Vec3d{0, y, 0}, 0.008, 0.008, 6);
    s.pipe(paint, {headLow, headLow + Vec3d{0.01, y, -0.03}, front + Vec3d{0, y, 0}}, {0.014, 0.014, 0.009}, 6);
  }
  s.tube(metal, seatTop, saddle, 0.013, 0.013, 8);
  s.ball(black, saddle + Vec3d{-0.04, 0, 0.02}, {0.12, 0.085, 0.035}, 12);
  s.ball(black, saddle + Vec3d{0.09, 0, 0.02}, {0.1, 0.03, 0.028}, 10);

  s.tube(metal, headHigh, bar, 0.014, 0.014, 8);
  const double back = sporty ? 0.05 : -0.17;
  const Vec3d left = bar + Vec3d{back, 0.29, 0.02};
  const Vec3d right = bar + Vec3d{back, -0.29, 0.02};
  s.pipe(metal, {right, bar + Vec3d{0.02, -0.2, 0.04}, bar, bar + Vec3d{0.02, 0.2, 0.04}, left},
         {0.012, 0.012, 0.012, 0.012, 0.012}, 7);
  for (const Vec3d& grip : {left, right})
    s.tube(black, grip, grip + Vec3d{back * 0.55, grip.y * 0.12, 0}, 0.017, 0.017, 7);

  // Adds the chain wheel, the chain guard, and the cranks with pedals (one up and forward, one down and back).
  s.revolve(metal, upright(bracket + Vec3d{0, -0.045, 0}), {{0, -0.004}, {0.09, -0.004}, {0.09, 0.004}, {0, 0.004}},
            20);
  s.box(black, {(bracket.x + rear.x) / 2, -0.062, 0.31}, {std::abs(rear.x - bracket.x), 0.015, 0.075});
  const Vec3d crank{0.15, 0, 0.08};
  const Vec3d leftPedal = bracket + crank + Vec3d{0, 0.13, 0};
  const Vec3d rightPedal = bracket - crank + Vec3d{0, -0.13, 0};
  s.tube(metal, bracket + Vec3d{0, 0.06, 0}, bracket + crank + Vec3d{0, 0.07, 0}, 0.012, 0.01, 6);
  s.tube(metal, bracket - Vec3d{0, 0.06, 0}, bracket - crank - Vec3d{0, 0.07, 0}, 0.012, 0.01, 6);
  for (const Vec3d& pedal : {leftPedal, rightPedal}) s.box(black, pedal, {0.09, 0.1, 0.025});

  if (!sporty) {
    appendMudguard(s, paint, rear, r + 0.025, 0.05, radians(-5), radians(175));
    appendMudguard(s, paint, front, r + 0.025, 0.05, radians(25), radians(190));
    appendRack(s, metal, rear, r, seatTop.x - 0.05);
  }
  s.box(reflector, {rear.x - r * 0.6, 0, r * 2 + 0.01}, {0.03, 0.07, 0.05});
  s.ball(metal, {headHigh.x + 0.09, 0, headHigh.z}, {0.05, 0.035, 0.035}, 10);
  s.box(reflector, {headHigh.x + 0.12, 0, headHigh.z - 0.06}, {0.012, 0.05, 0.035});
  if (basket) appendBasket(s, metal, {headHigh.x + 0.22, 0, headHigh.z + 0.06});
  if (fit)
    *fit = {saddle + Vec3d{0, 0, 0.05}, left + Vec3d{0, 0, 0.02}, right + Vec3d{0, 0, 0.02}, leftPedal, rightPedal};
  return s.finish();
}

Model makeMotorcycle(SceneBuilder& builder, std::uint64_t seed, int form, RiderFit* fit) {
  Draw draw(seed, fit != nullptr ? Kind::RiddenMotorcycle : Kind::Motorcycle, static_cast<std::uint32_t>(form));
  Shape s(builder, "motorcycle");
  const char* kName = "motorcycle";
  const SurfaceIndex paint = s.surface(kName, "car_paint");
  const SurfaceIndex metal = s.surface(kName, "metal_bare");
  const SurfaceIndex black = s.surface(kName, "plastic_black");
  const SurfaceIndex glass = s.surface(kName, "glass");
  const SurfaceIndex reflector = s.surface(kName, "sign_retroreflective");
  const double r = draw.in(0.3, 0.32);
  const double base = draw.in(1.36, 1.5);
  const Vec3d rear{-base / 2, 0, r};
  const Vec3d front{base / 2, 0, r};
  appendWheel(s, kName, at(rear), r, 0.16);
  appendWheel(s, kName, at(rear + Vec3d{0, -0.002, 0}, kPi), r * 0.98, 0.15);
  appendWheel(s, kName, at(front), r, 0.12);
  appendWheel(s, kName, at(front + Vec3d{0, -0.002, 0}, kPi), r * 0.98, 0.11);

  const Vec3d head{front.x - 0.3, 0, 0.88};
  for (const double y : {-0.095, 0.095}) {
    s.tube(metal, head + Vec3d{-0.02, y, 0.06}, front + Vec3d{0, y, 0}, 0.024, 0.028, 10);
    s.tube(metal, {-0.1, y, 0.45}, rear + Vec3d{0, y * 1.1, 0}, 0.025, 0.022, 8);
    s.tube(black, {-0.38, y, 0.68}, rear + Vec3d{0.05, y * 1.1, 0.02}, 0.03, 0.022, 10);
  }
  // Adds engine, tank, seat and tail.
  s.box(metal, {0.06, 0, 0.42}, {0.42, 0.3, 0.3});
  for (int k = 0; k < 5; ++k) s.box(metal, {0.14, 0, 0.58 + 0.03 * k}, {0.24, 0.26, 0.014});
  s.tube(metal, {0.14, 0, 0.5}, {0.14, 0, 0.72}, 0.09, 0.09, 12);
  s.box(black, {0.0, 0, 0.28}, {0.5, 0.2, 0.08});
  s.ball(paint, {0.13, 0, 0.83}, {0.31, 0.16, 0.135}, 18);
  s.tube(black, {-0.05, 0, 0.62}, head, 0.04, 0.05, 8);
  s.ball(black, {-0.3, 0, 0.78}, {0.32, 0.15, 0.07}, 16);
  s.ball(paint, {-0.66, 0, 0.8}, {0.24, 0.11, 0.075}, 14);
  s.box(paint, {-0.08, 0, 0.63}, {0.3, 0.22, 0.16});
  appendMudguard(s, paint, front, r + 0.04, 0.13, radians(20), radians(150));
  appendMudguard(s, black, rear, r + 0.05, 0.18, radians(60), radians(190));
  // Adds the exhaust on the right.
  s.pipe(metal, {{0.28, -0.1, 0.5}, {0.33, -0.15, 0.32}, {0.1, -0.18, 0.24}, {-0.35, -0.19, 0.28}, {-0.85, -0.2, 0.4}},
         {0.022, 0.022, 0.024, 0.045, 0.05}, 10);
  // Adds handlebar, mirrors, lamp, plate and stand.
  const Vec3d bar = head + Vec3d{-0.05, 0, 0.14};
  s.pipe(metal,
         {bar + Vec3d{-0.18, -0.38, 0.02}, bar + Vec3d{-0.04, -0.25, 0.05}, bar, bar + Vec3d{-0.04, 0.25, 0.05},
          bar + Vec3d{-0.18, 0.38, 0.02}},
         {0.013, 0.013, 0.013, 0.013, 0.013}, 8);
  if (fit != nullptr) {
    *fit = {.saddle = {-0.28, 0, 0.82},
            .leftGrip = bar + Vec3d{-0.15, 0.35, 0.03},
            .rightGrip = bar + Vec3d{-0.15, -0.35, 0.03},
            .leftPedal = {-0.08, 0.2, 0.33},
            .rightPedal = {-0.08, -0.2, 0.33}};
  }
  for (const double side : {-1.0, 1.0}) {
    s.tube(black, bar + Vec3d{-0.11, side * 0.31, 0.035}, bar + Vec3d{-0.19, side * 0.39, 0.02}, 0.019, 0.019, 8);
    s.tube(black, bar + Vec3d{-0.05, side * 0.24, 0.05}, bar + Vec3d{0.0, side * 0.3, 0.2}, 0.006, 0.006, 5);
    s.ball(black, bar + Vec3d{0.0, side * 0.32, 0.22}, {0.03, 0.075, 0.05}, 10);
  }
  s.ball(black, head + Vec3d{0.1, 0, 0.0}, {0.1, 0.1, 0.1}, 14);
  s.ball(glass, head + Vec3d{0.14, 0, 0.0}, {0.075, 0.085, 0.085}, 14);
  if (draw.chance(0.5)) {  // wind shield
    s.quad(glass, head + Vec3d{0.14, -0.17, 0.12}, head + Vec3d{0.14, 0.17, 0.12}, head + Vec3d{-0.02, 0.13, 0.42},
           head + Vec3d{-0.02, -0.13, 0.42});
  }
  s.box(reflector, {-0.92, 0, 0.62}, {0.02, 0.2, 0.2});
  s.box(reflector, {-0.89, 0, 0.79}, {0.03, 0.14, 0.06});
  s.tube(metal, {-0.05, 0.12, 0.3}, {-0.12, 0.3, 0.0}, 0.013, 0.013, 6);
  return s.finish();
}

}  // namespace scanmill::models
