// Builds cars, vans, trucks, buses, trailers, caravans, tractors and excavators. x is forward; sizes (m) are by eye.

#include <algorithm>
#include <array>
#include <utility>

#include "models/facade.h"
#include "models/models.h"

namespace scanmill::models {
namespace {

// The mean body of a kind of car and its side profile (m). x is 0 in the middle of the car.
struct CarShape {
  double length, width, floor, belt, beltRise, roofHalf, wheelRadius;  // as in BodyForm (facade.h)
  double nose, hood, roof, tail;                // heights of the bonnet's front and rear end, the roof and the boot
  double windBase, windTop, roofEnd, rearBase;  // x of the ends of windscreen, roof and rear window
};

// The bodies in the order of CarForm, by eye from usual cars of each kind.
// clang-format off
constexpr std::array<CarShape, kCarForms> kCarShapes{{
//   length width floor belt  rise  half  wheel   nose  hood  roof  tail    windscreen   roof   rear
    {4.1,  1.78, 0.2,  0.92, 0.02, 0.56, 0.31,   0.74, 0.98, 1.48, 0.95,   0.85, 0.2,  -1.45, -1.9},
    {4.7,  1.78, 0.2,  0.92, 0.02, 0.56, 0.31,   0.74, 0.98, 1.44, 1.02,   0.95, 0.3,  -0.95, -1.65},
    {4.65, 1.78, 0.2,  0.92, 0.02, 0.56, 0.31,   0.74, 0.98, 1.47, 0.95,   0.95, 0.3,  -1.9,  -2.2},
    {4.5,  1.82, 0.27, 1.06, 0.02, 0.56, 0.36,   0.88, 1.1,  1.68, 1.08,   0.85, 0.2,  -1.7,  -2.1},
    {4.6,  1.82, 0.2,  1.05, 0.02, 0.66, 0.31,   0.82, 1.12, 1.83, 1.08,   1.45, 0.55, -2.05, -2.22},
    {5.1,  1.82, 0.3,  1.08, 0,    0.56, 0.37,   0.92, 1.12, 1.76, 1.15,   1.0,  0.45, -0.75, -0.98},
    {5.3,  1.84, 0.24, 1.25, 0,    0.76, 0.34,   0.95, 1.32, 2.45, 1.3,    1.85, 1.05, -2.5,  -2.58},
}};
// clang-format on

// Returns the body of a kind of car, with its windows. Length and height vary at random by a few percent.
BodyForm carForm(CarForm kind, Draw& draw) {
  const CarShape& shape = kCarShapes[static_cast<std::size_t>(kind)];
  const double stretch = draw.in(0.97, 1.03);  // factor on all lengths
  const double height = shape.roof * draw.in(0.98, 1.02);
  const double windBase = shape.windBase * stretch, windTop = shape.windTop * stretch;
  const double end = shape.length * stretch / 2;
  const double rearBase = std::max(shape.rearBase * stretch, -end + 0.04);
  const double roofEnd = std::max(shape.roofEnd * stretch, rearBase + 0.06);
  BodyForm f{.length = shape.length * stretch,
             .width = shape.width,
             .floor = shape.floor,
             .belt = shape.belt,
             .beltRise = shape.beltRise,
             .roofHalf = shape.roofHalf,
             .profile = {{-end, shape.tail - 0.08},
                         {-end + 0.03, shape.tail},
                         {rearBase, shape.tail + 0.01},
                         {roofEnd, height - 0.05},
                         {(roofEnd + windTop) / 2, height},
                         {windTop, height - 0.04},
                         {windBase, shape.hood},
                         {end - 0.5, lerp(shape.nose, shape.hood, 0.55)},
                         {end - 0.12, shape.nose},
                         {end, shape.nose - 0.1}},
             .windscreen = {windTop + 0.07, windBase - 0.07},
             .rearWindow = {rearBase + std::min(0.1, (roofEnd - rearBase) * 0.15),
                            roofEnd - std::min(0.06, (roofEnd - rearBase) * 0.1)},
             .wheelRadius = shape.wheelRadius};
  std::ranges::sort(f.profile, {}, &Point2::x);
  const double front = lerp(windTop, windBase, 0.55);  // x: front end of the side windows
  const double middle = windTop - 0.75;                // x: the pillar between the front and the rear doors
  if (kind == CarForm::Delivery) {
    f.sideWindows = {{windTop - 0.35, front}};
    f.rearWindow = {};
  } else if (kind == CarForm::Pickup) {
    f.sideWindows = {{roofEnd + 0.1, windTop - 0.5}, {windTop - 0.42, front}};
    f.bed = {-end + 0.12, rearBase - 0.1};
  } else if (kind == CarForm::Wagon || kind == CarForm::Van || kind == CarForm::Suv) {
    f.sideWindows = {{roofEnd + 0.15, middle - 0.95}, {middle - 0.86, middle - 0.04}, {middle + 0.05, front}};
  } else {
    f.sideWindows = {{lerp(rearBase, roofEnd, 0.65), middle - 0.04}, {middle + 0.05, front}};
  }
  const double halfWheelbase = f.length * 0.5 * 0.6;
  f.axles = {-halfWheelbase * draw.in(0.98, 1.03), halfWheelbase * draw.in(1.03, 1.07)};
  return f;
}

// Returns the material of a random car paint. The shares of black (29.5 %), grey or silver (29.4 %) and white (15.7 %)
// apply to new cars in Germany in 2012 (Kraftfahrt-Bundesamt). The shares of blue (also for green and brown) and
// red, and equal shares of grey and silver, are estimates.
const char* paintOf(std::uint64_t seed, int number) {
  constexpr std::array<std::pair<double, const char*>, 6> kPaints{{{0.147, "car_paint_grey"},
                                                                   {0.295, "car_paint_black"},
                                                                   {0.157, "car_paint_white"},
                                                                   {0.177, "car_paint_blue"},
                                                                   {0.147, "car_paint_silver"},
                                                                   {0.077, "car_paint_red"}}};
  double remaining = Draw(seed, Kind::Paint, number).next();  // cumulative share that is left
  for (const auto& [share, paint] : kPaints) {
    remaining -= share;
    if (remaining < 0) return paint;
  }
  return kPaints.back().second;
}

constexpr double kCabLength = 2.0;  // m, length of a truck's cab

// Returns the cab of a truck whose cargo box is `cargoWidth` metres wide. The cab's sizes are by eye.
BodyForm truckCab(double cargoWidth) {
  return {.className = "truck",
          .length = kCabLength,
          .width = cargoWidth - 0.08,
          .floor = 0.45,
          .belt = 1.45,
          .beltRise = 0,
          .roofHalf = 0.98,
          .noseTaper = 0.05,
          .tailTaper = 0,
          .bulge = 0.06,
          .profile = {{-1, 2.55}, {-0.9, 2.62}, {0.3, 2.62}, {0.72, 2.52}, {0.93, 1.5}, {1, 1.3}},
          .windscreen = {0.76, 0.92},
          .sideWindows = {{-0.45, 0.62}},
          .axles = {0.0},
          .wheelRadius = 0.45,
          .wheelWidth = 0.27,
          .mirrors = false};
}

constexpr const char* kClass = "other_vehicle";

// Appends a trailer: a frame with a hitch, and an open box; half of the trailers have a cover.
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

// Appends a caravan: a body with windows, a door on the right, wheels, drawbar, support and gas box.
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

// Appends a driver's cab with posts, glass on all sides and a seat.
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

// Appends an excavator: two tracks, and an upper carriage with cab, boom, arm and bucket, turned by a random angle.
void appendExcavator(Shape& s, Draw& draw) {
  const auto [paint, track, metal] = s.surfaces(kClass, "painted_metal", "rubber", "metal_weathered");
  for (const double y : {-0.75, 0.75}) {
    std::vector<Point2> belt = regularPolygon(16, 0.32);  // in side view: a circle, whose halves are moved apart
    for (Point2& p : belt) p.x += p.x > 0 ? 0.95 : -0.95;
    s.prism(track, track, sideView({0, y + 0.2, 0.32}), belt, 0.4);
  }
  s.box(metal, {0, 0, 0.5}, {1.2, 1.2, 0.3});
  s.frame = at({0, 0, 0}, draw.in(-0.6, 0.6));
  s.box(paint, {-0.45, 0, 1.05}, {1.7, 1.7, 0.7});
  s.box(metal, {-1.25, 0, 1.0}, {0.35, 1.6, 0.8});  // counterweight
  appendCab(s, {0.3, 0.45, 1.75}, {1.2, 0.8, 1.4});
  // The boom leads from its foot to the elbow; the arm leads from the elbow to the wrist, where the bucket hangs.
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

Model makeCar(SceneBuilder& builder, std::uint64_t seed, CarForm form, int number) {
  Draw draw(seed, Kind::Car, number);
  Shape shape(builder, "car");
  BodyForm body = carForm(form, draw);
  body.paint = paintOf(seed, number);
  appendBody(shape, body);
  if (form == CarForm::Wagon || form == CarForm::Suv) {  // roof rails
    const SurfaceIndex metal = shape.surface("car", "metal_bare");
    const double z = body.profile[4].y + 0.01;  // just above the top of the roof
    for (const double y : {-0.5, 0.5}) {
      shape.pipe(metal, {{-1.25, y, z - 0.08}, {-1.1, y, z + 0.02}, {0.0, y, z + 0.03}, {0.15, y, z - 0.08}}, 0.017, 6);
    }
  }
  return shape.finish();
}

// Builds a truck: a cab in front, and behind it a cargo box on a chassis with one rear axle.
Model makeTruck(SceneBuilder& builder, std::uint64_t seed, int form) {
  Draw draw(seed, Kind::Truck, form);
  Shape shape(builder, "truck");
  const double length = draw.in(6.8, 8.6);
  const double width = 2.35;
  const double top = draw.in(3.1, 3.6);
  const double end = length / 2;

  shape.frame = at({end - kCabLength / 2 - 0.06, 0, 0});
  appendBody(shape, truckCab(width));
  shape.frame = {};

  const auto [metal, black, reflector] =
      shape.surfaces("truck", "painted_metal", "plastic_black", "sign_retroreflective");
  const double front = end - kCabLength - 0.2;  // x of the cargo box's front
  const double boxLength = front + end;
  const double middle = (front - end) / 2;
  constexpr double kBed = 0.95;  // m, height of the cargo box's floor
  const double middleZ = (kBed + top) / 2;
  shape.box(metal, {middle, 0, middleZ}, {boxLength, width, top - kBed});
  for (const double y : {-width / 2, width / 2}) {
    for (int k = 0; k <= 6; ++k) {
      shape.box(metal, {lerp(-end + 0.02, front - 0.02, k / 6.0), y, middleZ}, {0.06, 0.05, top - kBed + 0.03});  // rib
    }
    shape.box(reflector, {middle, y, kBed + 0.09}, {boxLength - 0.3, 0.02, 0.06});
    for (const double z : {0.5, 0.72}) {  // side guard
      shape.box(metal, {middle + 0.35, y * 0.96, z}, {boxLength - 2.4, 0.04, 0.1});
    }
  }
  for (const double y : {-0.42, 0.42}) shape.box(black, {middle + 0.5, y, 0.78}, {length - 1.4, 0.1, 0.22});  // frame
  shape.box(black, {middle + 0.1, 0, 0.9}, {boxLength - 0.3, 0.7, 0.08});
  const double axle = -end + 1.45;
  shape.rod(black, {axle, -0.9, 0.45}, {axle, 0.9, 0.45}, 0.07, 8);
  for (const double y : {0.72, 1.02}) appendWheels(shape, "truck", axle, y, 0.45, 0.26);
  shape.box(metal, {-end + 0.05, 0, 0.5}, {0.1, width - 0.1, 0.12});  // rear under-ride guard
  for (const double side : {-1.0, 1.0}) {
    shape.box(metal, {-end + 0.1, side * 0.7, 0.7}, {0.06, 0.08, 0.45});                       // the guard's support
    shape.box(reflector, {-end + 0.01, side * (width / 2 - 0.25), 0.66}, {0.06, 0.36, 0.14});  // rear lamp
    shape.box(metal, {-end - 0.012, side * 0.25, middleZ}, {0.04, 0.04, top - kBed - 0.1});    // bar of the doors
    const double x = end - 0.4;                                                                // x of the mirrors
    shape.rod(black, {x, side * (width / 2 - 0.12), 2.2}, {x + 0.1, side * (width / 2 + 0.14), 2.1}, 0.02, 6);
    shape.box(black, {x + 0.1, side * (width / 2 + 0.15), 1.85}, {0.08, 0.2, 0.5});
  }
  shape.box(reflector, {-end, 0, 0.66}, {0.05, 0.52, 0.12});  // number plate
  return shape.finish();
}

Model makeBus(SceneBuilder& builder, std::uint64_t seed) {
  Draw draw(seed, Kind::Bus);
  Shape shape(builder, "bus");
  const double length = draw.in(10.5, 12.0);
  const double end = length / 2;
  const double belt = draw.in(1.2, 1.35);
  const double roof = draw.in(2.95, 3.15);
  constexpr double kWidth = 2.5;
  std::vector<Span> sideWindows;
  constexpr int kWindows = 8;
  const double first = -end + 0.5;  // x of the rear end of the row of windows
  const double pitch = (end - 0.55 - first) / kWindows;
  for (int k = 0; k < kWindows; ++k) sideWindows.push_back({first + k * pitch, first + (k + 1) * pitch - 0.1});
  appendBody(shape, {.className = "bus",
                     .length = length,
                     .width = kWidth,
                     .floor = 0.32,
                     .belt = belt,
                     .beltRise = 0,
                     .roofHalf = 1.06,
                     .noseTaper = 0.06,
                     .tailTaper = 0.03,
                     .bulge = 0.07,
                     .profile = {{-end, roof - 0.3},
                                 {-end + 0.15, roof - 0.05},
                                 {-end + 0.6, roof},
                                 {end - 1, roof},
                                 {end - 0.42, roof - 0.08},
                                 {end - 0.08, belt - 0.05},
                                 {end, belt - 0.2}},
                     .windscreen = {end - 0.36, end - 0.085},
                     .sideWindows = sideWindows,
                     .axles = {-end + 3.1, end - 2.7},
                     .wheelRadius = 0.48,
                     .wheelWidth = 0.3,
                     .mirrors = false});

  const auto [metal, glass, black] = shape.surfaces("bus", "painted_metal", "glass", "plastic_black");
  shape.box(glass, {-end - 0.01, 0, roof - 0.75}, {0.08, 1.9, 0.8});  // rear window
  shape.box(black, {end - 0.47, 0, roof - 0.13}, {0.3, 1.6, 0.24});   // destination board
  shape.box(metal, {-end + 2.2, 0, roof + 0.08}, {2.4, 1.6, 0.3});    // air conditioning
  for (const double x : {end - 1.35, 0.2}) {                          // doors on the right
    shape.box(black, {x, -kWidth / 2 + 0.06, 1.28}, {1.25, 0.14, 1.9});
    for (const double dx : {-0.3, 0.3}) shape.box(glass, {x + dx, -kWidth / 2 + 0.05, 1.35}, {0.5, 0.15, 1.6});
  }
  for (const double side : {-1.0, 1.0}) {  // mirrors on arms
    shape.pipe(black,
               {{end - 0.3, side * 1.0, roof - 0.15},
                {end + 0.2, side * 1.22, roof - 0.2},
                {end + 0.25, side * 1.3, roof - 0.55}},
               0.025, 6);
    shape.box(black, {end + 0.25, side * 1.3, roof - 0.8}, {0.1, 0.22, 0.45});
  }
  return shape.finish();
}

Model makeWorkVehicle(SceneBuilder& builder, std::uint64_t seed, WorkVehicle kind, int number) {
  Draw draw(seed, Kind::WorkVehicle, static_cast<int>(kind) * 100 + number);
  Shape s(builder, "other vehicle");
  kAppend[static_cast<std::size_t>(kind)](s, draw);
  return s.finish();
}

}  // namespace scanmill::models
