// Cars, vans, trucks and buses: proportions of the bodies, and the parts attached to them.

#include <algorithm>
#include <array>
#include <utility>

#include "models/facade.h"

namespace scanmill::models {
namespace {

// The body of a kind of car and its side profile (m), before they vary at random; x is 0 in the middle.
struct CarShape {
  double length, width, floor, belt, beltRise, roofHalf, wheelRadius;  // as in BodyForm (facade.h)
  double nose, hood, height, tail;                                     // z: tip and base of the bonnet, roof, boot
  double windBase, windTop, roofEnd, rearBase;                         // x: ends of windscreen, roof and rear window
};

// The bodies in the order of CarForm.
// clang-format off
constexpr std::array<CarShape, 7> kCarShapes{{
    {4.1,  1.78, 0.2,  0.92, 0.02, 0.56, 0.31,   0.74, 0.98, 1.48, 0.95,   0.85, 0.2,  -1.45, -1.9},
    {4.7,  1.78, 0.2,  0.92, 0.02, 0.56, 0.31,   0.74, 0.98, 1.44, 1.02,   0.95, 0.3,  -0.95, -1.65},
    {4.65, 1.78, 0.2,  0.92, 0.02, 0.56, 0.31,   0.74, 0.98, 1.47, 0.95,   0.95, 0.3,  -1.9,  -2.2},
    {4.5,  1.82, 0.27, 1.06, 0.02, 0.56, 0.36,   0.88, 1.1,  1.68, 1.08,   0.85, 0.2,  -1.7,  -2.1},
    {4.6,  1.82, 0.2,  1.05, 0.02, 0.66, 0.31,   0.82, 1.12, 1.83, 1.08,   1.45, 0.55, -2.05, -2.22},
    {5.1,  1.82, 0.3,  1.08, 0,    0.56, 0.37,   0.92, 1.12, 1.76, 1.15,   1.0,  0.45, -0.75, -0.98},
    {5.3,  1.84, 0.24, 1.25, 0,    0.76, 0.34,   0.95, 1.32, 2.45, 1.3,    1.85, 1.05, -2.5,  -2.58},
}};
// clang-format on

// Returns the body of a kind of car, with the windows that go with it.
BodyForm carForm(CarForm kind, Draw& draw) {
  const CarShape& shape = kCarShapes[static_cast<std::size_t>(kind)];
  BodyForm f;
  f.length = shape.length;
  f.width = shape.width;
  f.floor = shape.floor;
  f.belt = shape.belt;
  f.beltRise = shape.beltRise;
  f.roofHalf = shape.roofHalf;
  f.wheelRadius = shape.wheelRadius;
  const double stretch = draw.in(0.97, 1.03);
  const double height = shape.height * draw.in(0.98, 1.02);
  f.length *= stretch;
  const double windBase = shape.windBase * stretch, windTop = shape.windTop * stretch;
  const double end = f.length / 2;
  const double rearBase = std::max(shape.rearBase * stretch, -end + 0.04);
  const double roofEnd = std::max(shape.roofEnd * stretch, rearBase + 0.06);
  f.profile = {{-end, shape.tail - 0.08},
               {-end + 0.03, shape.tail},
               {rearBase, shape.tail + 0.01},
               {roofEnd, height - 0.05},
               {(roofEnd + windTop) / 2, height},
               {windTop, height - 0.04},
               {windBase, shape.hood},
               {end - 0.5, lerp(shape.nose, shape.hood, 0.55)},
               {end - 0.12, shape.nose},
               {end, shape.nose - 0.1}};
  std::sort(f.profile.begin(), f.profile.end(), [](Point2 a, Point2 b) { return a.x < b.x; });
  f.windscreen = {windTop + 0.07, windBase - 0.07};
  f.rearWindow = {rearBase + std::min(0.1, (roofEnd - rearBase) * 0.15),
                  roofEnd - std::min(0.06, (roofEnd - rearBase) * 0.1)};
  const double front = lerp(windTop, windBase, 0.55);
  const double middle = windTop - 0.75;
  switch (kind) {
    case CarForm::Delivery:
      f.sideWindows = {{windTop - 0.35, front}};
      f.rearWindow = {};
      break;
    case CarForm::Pickup:
      f.sideWindows = {{roofEnd + 0.1, windTop - 0.5}, {windTop - 0.42, front}};
      f.bed = {-end + 0.12, rearBase - 0.1};
      break;
    case CarForm::Wagon:
    case CarForm::Van:
    case CarForm::Suv:
      f.sideWindows = {{roofEnd + 0.15, middle - 0.95}, {middle - 0.86, middle - 0.04}, {middle + 0.05, front}};
      break;
    default:
      f.sideWindows = {{lerp(rearBase, roofEnd, 0.65), middle - 0.04}, {middle + 0.05, front}};
      break;
  }
  const double base = f.length * 0.5 * 0.6;
  f.axles = {-base * draw.in(0.98, 1.03), base * draw.in(1.03, 1.07)};
  return f;
}

// Returns the material of a car's paint. The shares of black, grey with silver, and white are those of the cars that
// were newly registered in Germany in 2012 (Kraftfahrt-Bundesamt: 29.5, 29.4 and 15.7 %). How the rest divides into
// blue with green and brown, and red, and that half of the grey cars are silver, are estimates.
const char* paintOf(std::uint64_t seed, int number) {
  constexpr std::array<std::pair<double, const char*>, 6> kPaints{{{0.147, "car_paint_grey"},
                                                                   {0.295, "car_paint_black"},
                                                                   {0.157, "car_paint_white"},
                                                                   {0.177, "car_paint_blue"},
                                                                   {0.147, "car_paint_silver"},
                                                                   {0.077, "car_paint_red"}}};
  double left = Draw(seed, Kind::Paint, static_cast<std::uint32_t>(number)).next();
  for (const auto& [share, paint] : kPaints) {
    left -= share;
    if (left < 0) return paint;
  }
  return kPaints.back().second;
}

constexpr double kCab = 2.0;  // m, length of a truck's cab

BodyForm truckCab(double width) {
  BodyForm cab;
  cab.className = "truck";
  cab.length = kCab;
  cab.width = width - 0.08;
  cab.floor = 0.45;
  cab.belt = 1.45;
  cab.beltRise = 0;
  cab.roofHalf = 0.98;
  cab.noseTaper = 0.05;
  cab.tailTaper = 0;
  cab.bulge = 0.06;
  cab.wheelRadius = 0.45;
  cab.wheelWidth = 0.27;
  cab.profile = {{-1, 2.55}, {-0.9, 2.62}, {0.3, 2.62}, {0.72, 2.52}, {0.93, 1.5}, {1, 1.3}};
  cab.windscreen = {0.76, 0.92};
  cab.sideWindows = {{-0.45, 0.62}};
  cab.axles = {0.0};
  cab.mirrors = false;
  return cab;
}

}  // namespace

Model makeCar(SceneBuilder& builder, std::uint64_t seed, CarForm form, int number) {
  Draw draw(seed, Kind::Car, static_cast<std::uint32_t>(number));
  Shape shape(builder, "car");
  BodyForm body = carForm(form, draw);
  body.paint = paintOf(seed, number);
  appendBody(shape, body);
  if (form == CarForm::Wagon || form == CarForm::Suv) {  // roof rails
    const SurfaceIndex metal = shape.surface("car", "metal_bare");
    const double z = body.profile[4].y + 0.01;
    for (const double y : {-0.5, 0.5}) {
      shape.pipe(metal, {{-1.25, y, z - 0.08}, {-1.1, y, z + 0.02}, {0.0, y, z + 0.03}, {0.15, y, z - 0.08}},
                 {0.017, 0.017, 0.017, 0.017}, 6);
    }
  }
  return shape.finish();
}

Model makeTruck(SceneBuilder& builder, std::uint64_t seed, int form) {
  Draw draw(seed, Kind::Truck, static_cast<std::uint32_t>(form));
  Shape shape(builder, "truck");
  const double length = draw.in(6.8, 8.6);
  const double width = 2.35;
  const double height = draw.in(3.1, 3.6);
  const double end = length / 2;

  shape.frame = at({end - kCab / 2 - 0.06, 0, 0});
  appendBody(shape, truckCab(width));
  shape.frame = {};

  const SurfaceIndex metal = shape.surface("truck", "painted_metal");
  const SurfaceIndex black = shape.surface("truck", "plastic_black");
  const SurfaceIndex reflector = shape.surface("truck", "sign_retroreflective");
  const double front = end - kCab - 0.2;
  const double cargo = front + end;
  const double middle = (front - end) / 2;
  constexpr double kBed = 0.95;
  shape.box(metal, {middle, 0, (kBed + height) / 2}, {cargo, width, height - kBed});
  for (const double y : {-width / 2, width / 2}) {  // adds ribs, a reflecting band and an under-ride guard
    for (int k = 0; k <= 6; ++k) {
      const double x = lerp(-end + 0.02, front - 0.02, k / 6.0);
      shape.box(metal, {x, y, (kBed + height) / 2}, {0.06, 0.05, height - kBed + 0.03});
    }
    shape.box(reflector, {middle, y, kBed + 0.09}, {cargo - 0.3, 0.02, 0.06});
    for (const double z : {0.5, 0.72}) shape.box(metal, {middle + 0.35, y * 0.96, z}, {cargo - 2.4, 0.04, 0.1});
  }
  for (const double y : {-0.42, 0.42}) shape.box(black, {middle + 0.5, y, 0.78}, {length - 1.4, 0.1, 0.22});
  shape.box(black, {middle + 0.1, 0, 0.9}, {cargo - 0.3, 0.7, 0.08});
  const double rear = -end + 1.45;  // position of the rear axle
  shape.tube(black, {rear, -0.9, 0.45}, {rear, 0.9, 0.45}, 0.07, 0.07, 8);
  for (const double y : {0.72, 1.02}) appendWheels(shape, "truck", rear, y, 0.45, 0.26);
  shape.box(metal, {-end + 0.05, 0, 0.5}, {0.1, width - 0.1, 0.12});
  for (const double side : {-1.0, 1.0}) {
    shape.box(metal, {-end + 0.1, side * 0.7, 0.7}, {0.06, 0.08, 0.45});
    shape.box(reflector, {-end + 0.01, side * (width / 2 - 0.25), 0.66}, {0.06, 0.36, 0.14});
    shape.box(metal, {-end - 0.012, side * 0.25, (kBed + height) / 2}, {0.04, 0.04, height - kBed - 0.1});
    const double x = end - 0.4;  // position of the mirrors along the truck
    shape.tube(black, {x, side * (width / 2 - 0.12), 2.2}, {x + 0.1, side * (width / 2 + 0.14), 2.1}, 0.02, 0.02, 6);
    shape.box(black, {x + 0.1, side * (width / 2 + 0.15), 1.85}, {0.08, 0.2, 0.5});
  }
  shape.box(reflector, {-end, 0, 0.66}, {0.05, 0.52, 0.12});
  return shape.finish();
}

Model makeBus(SceneBuilder& builder, std::uint64_t seed) {
  Draw draw(seed, Kind::Bus);
  Shape shape(builder, "bus");
  BodyForm f;
  f.className = "bus";
  f.length = draw.in(10.5, 12.0);
  f.width = 2.5;
  f.floor = 0.32;
  f.belt = draw.in(1.2, 1.35);
  f.beltRise = 0;
  f.roofHalf = 1.06;
  f.noseTaper = 0.06;
  f.tailTaper = 0.03;
  f.bulge = 0.07;
  f.wheelRadius = 0.48;
  f.wheelWidth = 0.3;
  const double end = f.length / 2;
  const double roof = draw.in(2.95, 3.15);
  f.profile = {{-end, roof - 0.3},        {-end + 0.15, roof - 0.05},  {-end + 0.6, roof}, {end - 1, roof},
               {end - 0.42, roof - 0.08}, {end - 0.08, f.belt - 0.05}, {end, f.belt - 0.2}};
  f.windscreen = {end - 0.36, end - 0.085};
  f.axles = {-end + 3.1, end - 2.7};
  f.mirrors = false;
  const double low = -end + 0.5;
  const double high = end - 0.55;
  constexpr int kWindows = 8;
  const double pitch = (high - low) / kWindows;
  for (int k = 0; k < kWindows; ++k) f.sideWindows.push_back({low + k * pitch, low + (k + 1) * pitch - 0.1});
  appendBody(shape, f);

  const SurfaceIndex metal = shape.surface("bus", "painted_metal");
  const SurfaceIndex glass = shape.surface("bus", "glass");
  const SurfaceIndex black = shape.surface("bus", "plastic_black");
  shape.box(glass, {-end - 0.01, 0, roof - 0.75}, {0.08, 1.9, 0.8});  // rear window
  shape.box(black, {end - 0.47, 0, roof - 0.13}, {0.3, 1.6, 0.24});   // destination board
  shape.box(metal, {-end + 2.2, 0, roof + 0.08}, {2.4, 1.6, 0.3});    // air conditioning
  for (const double x : {end - 1.35, 0.2}) {                          // doors on the right
    shape.box(black, {x, -f.width / 2 + 0.06, 1.28}, {1.25, 0.14, 1.9});
    for (const double dx : {-0.3, 0.3}) shape.box(glass, {x + dx, -f.width / 2 + 0.05, 1.35}, {0.5, 0.15, 1.6});
  }
  for (const double side : {-1.0, 1.0}) {
    shape.pipe(black,
               {{end - 0.3, side * 1.0, roof - 0.15},
                {end + 0.2, side * 1.22, roof - 0.2},
                {end + 0.25, side * 1.3, roof - 0.55}},
               {0.025, 0.025, 0.025}, 6);
    shape.box(black, {end + 0.25, side * 1.3, roof - 0.8}, {0.1, 0.22, 0.45});
  }
  return shape.finish();
}

}  // namespace scanmill::models
