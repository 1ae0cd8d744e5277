// Builds bicycles and motorcycles.

#include <algorithm>
#include <cmath>

#include "models/models.h"

namespace scanmill::models {
namespace {

// Returns a frame that rotates z to y: tori and revolved shapes about z then stand upright, with their axis along y.
Affine upright(const Vec3d& center) {
  return {{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, center};
}

// An arc about a wheel's hub, with `radius` in m, from the angle `begin` to `end` (rad; 0 is forward, pi / 2 up).
struct WheelArc {
  Vec3d hub;
  double radius, begin, end;
};

// Appends a thin strip of `width` metres along an arc.
void appendMudguard(Shape& s, SurfaceIndex surface, const WheelArc& arc, double width) {
  std::vector<std::vector<Vec3d>> rows;
  constexpr int kSteps = 14;
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = lerp(arc.begin, arc.end, double(k) / kSteps);
    const auto rim = [&](double r, double y) { return arc.hub + Vec3d{r * std::cos(angle), y, r * std::sin(angle)}; };
    rows.push_back({rim(arc.radius - 0.01, -width / 2), rim(arc.radius, 0), rim(arc.radius - 0.01, width / 2),
                    rim(arc.radius - 0.006, 0)});
  }
  s.grid(rows, Loop::Closed, surface);
}

// Appends tyre, rim, hub and spokes. Spokes begin alternately at the left and the right end of the hub.
void appendBicycleWheel(Shape& s, const Vec3d& hub, double radius) {
  const auto [rubber, metal] = s.surfaces("bicycle", "rubber", "metal_bare");
  s.torus(rubber, upright(hub), radius - 0.019, 0.019, 36, 8);
  s.torus(metal, upright(hub), radius - 0.045, 0.011, 36, 6);
  s.rod(metal, hub + Vec3d{0, -0.06, 0}, hub + Vec3d{0, 0.06, 0}, 0.02, 8);
  double side = 0.03;  // m, half of the distance between the hub's ends
  for (const Point2& rim : regularPolygon(18, radius - 0.05)) {
    s.rod(metal, hub + Vec3d{0, side, 0}, hub + Vec3d{rim.x, 0, rim.y}, 0.002, 3);
    side = -side;
  }
}

// Appends a luggage rack of tubes above the rear wheel, with its front end at x = `seatX` (m).
void appendRack(Shape& s, SurfaceIndex metal, const Vec3d& rear, double wheelRadius, double seatX) {
  const double rack = wheelRadius * 2 + 0.06;  // m, height of the rack
  for (const double y : {-0.055, 0.055}) {
    s.rod(metal, {rear.x - 0.2, y, rack}, {seatX, y, rack}, 0.006, 5);
    s.rod(metal, {rear.x - 0.1, y, rack}, {rear.x, y, wheelRadius}, 0.005, 5);
  }
  for (const double x : {-0.2, -0.1, 0.0, 0.1}) {
    s.rod(metal, {rear.x + x, -0.055, rack}, {rear.x + x, 0.055, rack}, 0.005, 5);
  }
}

// Appends a basket of wires about a point in front of the handlebar: three rectangles, and 12 wires that connect them.
void appendBasket(Shape& s, SurfaceIndex metal, const Vec3d& center) {
  constexpr double kHalfHeight = 0.12;
  // Returns a point at the height z (m, above `center`). `x`, `y`: from -1 to 1 between opposite sides of the basket.
  const auto at = [&](double x, double y, double z) {
    const double half = 0.12 + z * 0.1;  // m, half of the length along the bicycle; the basket widens upwards
    return center + Vec3d{x * half, y * 1.3 * half, z};
  };
  for (const double z : {-kHalfHeight, 0.0, kHalfHeight}) {
    // The ring ends 3 mm above its start, so that it does not cross itself there.
    s.pipe(metal, {at(-1, -1, z), at(1, -1, z), at(1, 1, z), at(-1, 1, z), at(-1, -1, z) + Vec3d{0, 0, 0.003}}, 0.005,
           4);
  }
  for (const Point2& p : regularPolygon(12, 1)) {
    const Point2 q{std::clamp(p.x * 1.4, -1.0, 1.0), std::clamp(p.y * 1.4, -1.0, 1.0)};  // on the square's sides
    s.rod(metal, at(q.x, q.y, -kHalfHeight), at(q.x, q.y, kHalfHeight), 0.003, 3);
  }
}

// The points of a bicycle's frame (m), by eye from usual city bicycles.
struct BicycleFrame {
  Vec3d rear, front;  // hubs
  Vec3d bracket{-0.06, 0, 0.285};
  Vec3d seatTop, saddle;
  Vec3d headLow, headHigh;  // ends of the head tube
  Vec3d bar;                // middle of the handlebar
};

// Appends the tubes of the frame, fork and seat post, and the saddle.
void appendBicycleFrame(Shape& s, const BicycleFrame& f, bool stepThrough) {
  const auto [paint, black] = s.surfaces("bicycle", "painted_metal", "plastic_black");
  s.rod(paint, f.bracket, f.seatTop, 0.016, 8);
  s.rod(paint, f.bracket, f.headLow, 0.02, 8);
  s.rod(paint, stepThrough ? f.bracket + (f.seatTop - f.bracket) * 0.4 : f.seatTop,
        stepThrough ? f.headLow + (f.headHigh - f.headLow) * 0.4 : f.headHigh, 0.017, 8);
  s.rod(paint, f.headLow, f.headHigh, 0.022, 8);
  for (const double y : {-0.055, 0.055}) {  // stays at both sides of the rear wheel, and the fork
    s.tube(paint, f.bracket + Vec3d{0, y * 0.5, 0}, f.rear + Vec3d{0, y, 0}, 0.01, 0.008, 6);
    s.rod(paint, f.seatTop + Vec3d{0, y * 0.3, -0.03}, f.rear + Vec3d{0, y, 0}, 0.008, 6);
    s.pipe(paint, {f.headLow, f.headLow + Vec3d{0.01, y, -0.03}, f.front + Vec3d{0, y, 0}}, {0.014, 0.014, 0.009}, 6);
  }
  s.rod(s.surface("bicycle", "metal_bare"), f.seatTop, f.saddle, 0.013, 8);
  s.ball(black, f.saddle + Vec3d{-0.04, 0, 0.02}, {0.12, 0.085, 0.035}, 12);
  s.ball(black, f.saddle + Vec3d{0.09, 0, 0.02}, {0.1, 0.03, 0.028}, 10);
}

// Appends chain wheel, guard, cranks and pedals. `crank`: vector (m, y = 0) from the bracket to the left crank's end.
void appendCranks(Shape& s, const BicycleFrame& f, const Vec3d& crank, const Vec3d& leftPedal,
                  const Vec3d& rightPedal) {
  const auto [metal, black] = s.surfaces("bicycle", "metal_bare", "plastic_black");
  s.revolve(metal, upright(f.bracket + Vec3d{0, -0.045, 0}), {{0, -0.004}, {0.09, -0.004}, {0.09, 0.004}, {0, 0.004}},
            20);
  s.box(black, {(f.bracket.x + f.rear.x) / 2, -0.062, 0.31}, {std::abs(f.rear.x - f.bracket.x), 0.015, 0.075});
  s.tube(metal, f.bracket + Vec3d{0, 0.06, 0}, f.bracket + crank + Vec3d{0, 0.07, 0}, 0.012, 0.01, 6);
  s.tube(metal, f.bracket - Vec3d{0, 0.06, 0}, f.bracket - crank - Vec3d{0, 0.07, 0}, 0.012, 0.01, 6);
  for (const Vec3d& pedal : {leftPedal, rightPedal}) s.box(black, pedal, {0.09, 0.1, 0.025});
}

constexpr const char* kMotorcycle = "motorcycle";  // class

// Appends the engine with its cooling fins, the tank, the seat and the tail. Sizes are by eye.
void appendEngineAndSeat(Shape& s, const Vec3d& head) {
  const auto [paint, metal, black] = s.surfaces(kMotorcycle, "car_paint", "metal_bare", "plastic_black");
  s.box(metal, {0.06, 0, 0.42}, {0.42, 0.3, 0.3});
  for (int k = 0; k < 5; ++k) s.box(metal, {0.14, 0, 0.58 + 0.03 * k}, {0.24, 0.26, 0.014});  // fins
  s.rod(metal, {0.14, 0, 0.5}, {0.14, 0, 0.72}, 0.09, 12);                                    // cylinder
  s.box(black, {0.0, 0, 0.28}, {0.5, 0.2, 0.08});                                             // oil pan
  s.ball(paint, {0.13, 0, 0.83}, {0.31, 0.16, 0.135}, 18);                                    // tank
  s.tube(black, {-0.05, 0, 0.62}, head, 0.04, 0.05, 8);                                       // frame
  s.ball(black, {-0.3, 0, 0.78}, {0.32, 0.15, 0.07}, 16);                                     // seat
  s.ball(paint, {-0.66, 0, 0.8}, {0.24, 0.11, 0.075}, 14);                                    // tail
  s.box(paint, {-0.08, 0, 0.63}, {0.3, 0.22, 0.16});                                          // side covers
}

}  // namespace

Model makeBicycle(SceneBuilder& builder, std::uint64_t seed, int form, RiderFit* fit) {
  Draw draw(seed, fit != nullptr ? Kind::RiddenBicycle : Kind::Bicycle, form);
  Shape s(builder, "bicycle");
  const auto [paint, metal, black, reflector] =
      s.surfaces("bicycle", "painted_metal", "metal_bare", "plastic_black", "sign_retroreflective");

  const double r = draw.in(0.335, 0.355);
  const double wheelbase = draw.in(1.02, 1.12);
  const bool stepThrough = draw.chance(0.5);
  const bool basket = draw.chance(0.4);
  const bool sporty = !stepThrough && draw.chance(0.5);
  const double size = draw.in(0.94, 1.06);  // factor on the height of the saddle
  const double frontX = wheelbase * 0.53;
  const BicycleFrame f{.rear = {-wheelbase * 0.47, 0, r},
                       .front = {frontX, 0, r},
                       .seatTop = {-0.22, 0, 0.28 + 0.5 * size},
                       .saddle = {-0.26, 0, 0.28 + 0.66 * size},
                       .headLow = {frontX - 0.13, 0, 0.68},
                       .headHigh = {frontX - 0.18, 0, 0.86},
                       .bar = {frontX - 0.2, 0, sporty ? 0.96 : 1.06}};
  appendBicycleWheel(s, f.rear, r);
  appendBicycleWheel(s, f.front, r);
  appendBicycleFrame(s, f, stepThrough);

  s.rod(metal, f.headHigh, f.bar, 0.014, 8);
  const double gripX = sporty ? 0.05 : -0.17;  // m along x, from the middle of the handlebar to the grips
  const Vec3d left = f.bar + Vec3d{gripX, 0.29, 0.02};
  const Vec3d right = f.bar + Vec3d{gripX, -0.29, 0.02};
  s.pipe(metal, {right, f.bar + Vec3d{0.02, -0.2, 0.04}, f.bar, f.bar + Vec3d{0.02, 0.2, 0.04}, left}, 0.012, 7);
  for (const Vec3d& grip : {left, right}) {
    s.rod(black, grip, grip + Vec3d{gripX * 0.55, grip.y * 0.12, 0}, 0.017, 7);
  }
  // The left pedal is up and forward, the right one down and back.
  const Vec3d crank{0.15, 0, 0.08};
  const Vec3d leftPedal = f.bracket + crank + Vec3d{0, 0.13, 0};
  const Vec3d rightPedal = f.bracket - crank + Vec3d{0, -0.13, 0};
  appendCranks(s, f, crank, leftPedal, rightPedal);

  if (!sporty) {
    appendMudguard(s, paint, {f.rear, r + 0.025, radians(-5), radians(175)}, 0.05);
    appendMudguard(s, paint, {f.front, r + 0.025, radians(25), radians(190)}, 0.05);
    appendRack(s, metal, f.rear, r, f.seatTop.x - 0.05);
  }
  s.box(reflector, {f.rear.x - r * 0.6, 0, r * 2 + 0.01}, {0.03, 0.07, 0.05});  // rear lamp
  s.ball(metal, {f.headHigh.x + 0.09, 0, f.headHigh.z}, {0.05, 0.035, 0.035}, 10);
  s.box(reflector, {f.headHigh.x + 0.12, 0, f.headHigh.z - 0.06}, {0.012, 0.05, 0.035});
  if (basket) appendBasket(s, metal, {f.headHigh.x + 0.22, 0, f.headHigh.z + 0.06});
  if (fit != nullptr) {
    *fit = {f.saddle + Vec3d{0, 0, 0.05}, left + Vec3d{0, 0, 0.02}, right + Vec3d{0, 0, 0.02}, leftPedal, rightPedal};
  }
  return s.finish();
}

Model makeMotorcycle(SceneBuilder& builder, std::uint64_t seed, int form, RiderFit* fit) {
  Draw draw(seed, fit != nullptr ? Kind::RiddenMotorcycle : Kind::Motorcycle, form);
  Shape s(builder, "motorcycle");
  const auto [paint, metal, black, glass, reflector] =
      s.surfaces(kMotorcycle, "car_paint", "metal_bare", "plastic_black", "glass", "sign_retroreflective");
  const double r = draw.in(0.3, 0.32);
  const double wheelbase = draw.in(1.36, 1.5);
  const Vec3d rear{-wheelbase / 2, 0, r};
  const Vec3d front{wheelbase / 2, 0, r};
  // Each wheel is two car wheels back to back, because a car wheel has a rim on only one side.
  appendWheel(s, kMotorcycle, at(rear), r, 0.16);
  appendWheel(s, kMotorcycle, at(rear + Vec3d{0, -0.002, 0}, kPi), r * 0.98, 0.15);
  appendWheel(s, kMotorcycle, at(front), r, 0.12);
  appendWheel(s, kMotorcycle, at(front + Vec3d{0, -0.002, 0}, kPi), r * 0.98, 0.11);

  const Vec3d head{front.x - 0.3, 0, 0.88};  // steering head
  for (const double y : {-0.095, 0.095}) {   // fork, swing arm and shock absorber
    s.tube(metal, head + Vec3d{-0.02, y, 0.06}, front + Vec3d{0, y, 0}, 0.024, 0.028, 10);
    s.tube(metal, {-0.1, y, 0.45}, rear + Vec3d{0, y * 1.1, 0}, 0.025, 0.022, 8);
    s.tube(black, {-0.38, y, 0.68}, rear + Vec3d{0.05, y * 1.1, 0.02}, 0.03, 0.022, 10);
  }
  appendEngineAndSeat(s, head);
  appendMudguard(s, paint, {front, r + 0.04, radians(20), radians(150)}, 0.13);
  appendMudguard(s, black, {rear, r + 0.05, radians(60), radians(190)}, 0.18);
  // The exhaust is on the right.
  s.pipe(metal, {{0.28, -0.1, 0.5}, {0.33, -0.15, 0.32}, {0.1, -0.18, 0.24}, {-0.35, -0.19, 0.28}, {-0.85, -0.2, 0.4}},
         {0.022, 0.022, 0.024, 0.045, 0.05}, 10);
  const Vec3d bar = head + Vec3d{-0.05, 0, 0.14};  // middle of the handlebar
  s.pipe(metal,
         {bar + Vec3d{-0.18, -0.38, 0.02}, bar + Vec3d{-0.04, -0.25, 0.05}, bar, bar + Vec3d{-0.04, 0.25, 0.05},
          bar + Vec3d{-0.18, 0.38, 0.02}},
         0.013, 8);
  if (fit != nullptr) {
    *fit = {.saddle = {-0.28, 0, 0.82},
            .leftGrip = bar + Vec3d{-0.15, 0.35, 0.03},
            .rightGrip = bar + Vec3d{-0.15, -0.35, 0.03},
            .leftPedal = {-0.08, 0.2, 0.33},
            .rightPedal = {-0.08, -0.2, 0.33}};
  }
  for (const double side : {-1.0, 1.0}) {  // grips, and mirrors on rods
    s.rod(black, bar + Vec3d{-0.11, side * 0.31, 0.035}, bar + Vec3d{-0.19, side * 0.39, 0.02}, 0.019, 8);
    s.rod(black, bar + Vec3d{-0.05, side * 0.24, 0.05}, bar + Vec3d{0.0, side * 0.3, 0.2}, 0.006, 5);
    s.ball(black, bar + Vec3d{0.0, side * 0.32, 0.22}, {0.03, 0.075, 0.05}, 10);
  }
  s.ball(black, head + Vec3d{0.1, 0, 0.0}, {0.1, 0.1, 0.1}, 14);  // headlamp
  s.ball(glass, head + Vec3d{0.14, 0, 0.0}, {0.075, 0.085, 0.085}, 14);
  if (draw.chance(0.5)) {  // wind shield
    s.quad(glass, head + Vec3d{0.14, -0.17, 0.12}, head + Vec3d{0.14, 0.17, 0.12}, head + Vec3d{-0.02, 0.13, 0.42},
           head + Vec3d{-0.02, -0.13, 0.42});
  }
  s.box(reflector, {-0.92, 0, 0.62}, {0.02, 0.2, 0.2});           // number plate
  s.box(reflector, {-0.89, 0, 0.79}, {0.03, 0.14, 0.06});         // rear lamp
  s.rod(metal, {-0.05, 0.12, 0.3}, {-0.12, 0.3, 0.0}, 0.013, 6);  // stand
  return s.finish();
}

}  // namespace scanmill::models
