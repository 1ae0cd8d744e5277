// Builds people and animals. A person's elbows and knees are computed from shoulders and hips, hands and feet.

#include <algorithm>
#include <array>
#include <cmath>

#include "models/models.h"

namespace scanmill::models {
namespace {

constexpr double kPoseHeight = 1.75;  // m, height of a person in a Pose; other people are scaled

// Positions of joints in the person's frame (x forward, y left, z up; m). Lengths of limbs are by eye.
struct Pose {
  Vec3d hips{0, 0, 0.93};
  Vec3d shoulders{0, 0, 1.43};
  Vec3d head{0.02, 0, 1.64};
  Vec3d leftAnkle{0, 0.1, 0.09}, rightAnkle{0, -0.1, 0.09};
  Vec3d leftHand{0.04, 0.27, 0.83}, rightHand{0.04, -0.27, 0.83};
  double leftPitch = 0, rightPitch = 0;  // rad, pitch of the feet; positive: the heel is lifted
  Vec3d elbowDirection{-1, 0, -0.2};     // direction in which elbows point
};

struct Clothes {
  const char* upper = "cloth";
  const char* lower = "cloth_dark";
  bool skirt = false, coat = false, hat = false, backpack = false, bag = false, helmet = false;
  double girth = 1;  // factor on the width of the trunk and the limbs
};

// Returns the joint of a limb from `a` to `b`, bent towards `outwards`. `upper`, `lower`: lengths of the two parts (m).
Vec3d middleJoint(const Vec3d& a, const Vec3d& b, double upper, double lower, const Vec3d& outwards) {
  const double reach = std::min(length(b - a), (upper + lower) * 0.999);
  const Vec3d axis = normalized(b - a);
  const double x = (reach * reach + upper * upper - lower * lower) / (2 * reach);  // m along the axis
  const double h = std::sqrt(std::max(0.0, upper * upper - x * x));                // m from the axis
  return a + axis * x + normalized(outwards - axis * dot(outwards, axis)) * h;
}

class PersonMaker {
 public:
  PersonMaker(Shape& shape, std::string_view className, const Clothes& clothes)
      : s_(shape),
        c_(clothes),
        skin_(s_.surface(className, "skin")),
        upper_(s_.surface(className, clothes.upper)),
        lower_(s_.surface(className, clothes.lower)),
        dark_(s_.surface(className, "cloth_dark")),
        plastic_(s_.surface(className, "plastic_black")) {}

  // Adds the body in a pose, then a backpack and a bag if the person has them.
  void make(const Pose& p) {
    torso(p);
    head(p);
    for (const double side : {1.0, -1.0}) {
      const bool left = side > 0;
      leg(p.hips + Vec3d{0, side * 0.09, 0}, left ? p.leftAnkle : p.rightAnkle, left ? p.leftPitch : p.rightPitch);
      arm(p.shoulders + Vec3d{0, side * 0.185 * c_.girth, -0.055}, left ? p.leftHand : p.rightHand, p.elbowDirection,
          side);
    }
    if (c_.bag) {
      const Vec3d hand = p.rightHand;
      s_.box(dark_, hand + Vec3d{0, -0.02, -0.32}, {0.3, 0.1, 0.28});
      s_.torus(dark_, {{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, hand + Vec3d{0, -0.02, -0.12}}, 0.09, 0.008, 14, 5);
    }
    if (c_.backpack) {
      const Vec3d up = normalized(p.shoulders - p.hips);
      const Vec3d back = normalized(cross(up, Vec3d{0, 1, 0}));
      s_.ball(dark_, p.hips + up * 0.34 + back * 0.19, {0.12, 0.15, 0.23}, 14);
    }
  }

 private:
  // Adds the trunk or coat (elliptic rings from the seat, or from the thighs, up to the neck), the neck, and a skirt.
  void torso(const Pose& p) {
    const Vec3d up = normalized(p.shoulders - p.hips);
    const Vec3d left{0, 1, 0};
    const Vec3d forward = normalized(cross(left, up));
    const double trunk = length(p.shoulders - p.hips);
    struct BodyRing {
      double t;                      // position along the trunk: 0 at the hips, 1 at the shoulders
      double halfX, halfY, forward;  // m, half axes, and offset of the centre
    };
    const double g = c_.girth;
    std::vector<BodyRing> rings{
        {-0.17, 0.02, 0.03, -0.01},      {-0.14, 0.10 * g, 0.15 * g, -0.01}, {-0.04, 0.125 * g, 0.17 * g, -0.015},
        {0.15, 0.115 * g, 0.16 * g, 0},  {0.38, 0.11 * g, 0.148 * g, 0.01},  {0.62, 0.122 * g, 0.165 * g, 0.015},
        {0.82, 0.112 * g, 0.182 * g, 0}, {0.95, 0.09, 0.17, -0.01},          {1.01, 0.075, 0.125, -0.005},
        {1.07, 0.058, 0.07, 0},          {1.12, 0.05, 0.055, 0.01}};
    if (c_.coat) {
      rings.front() = {-0.75, 0.02, 0.03, 0};
      rings.insert(rings.begin() + 1, {-0.75, 0.17 * g, 0.2 * g, 0});
    }
    const auto pointsOf = [&](const BodyRing& r) {
      std::vector<Vec3d> points;
      const Vec3d center = p.hips + up * (r.t * trunk) + forward * r.forward;
      for (const Point2& c : regularPolygon(16, 1)) {
        points.push_back(center + forward * (r.halfX * c.x) + left * (r.halfY * c.y));
      }
      return points;
    };
    std::vector<std::vector<Vec3d>> rows;
    for (const BodyRing& r : rings) rows.push_back(pointsOf(r));
    const int seat = c_.coat ? 0 : 2;  // number of rows that belong to the trousers
    s_.grid(rows, Loop::Closed, [&](int row, int) { return row < seat ? lower_ : upper_; });
    if (c_.skirt) {
      s_.grid({pointsOf({0.1, 0.12 * g, 0.165 * g, 0}), pointsOf({-0.35, 0.19, 0.22, 0}),
               pointsOf({-0.95, 0.26, 0.27, 0}), pointsOf({-0.94, 0.02, 0.02, 0})},
              Loop::Closed, lower_);
    }
    s_.tube(skin_, p.shoulders + up * 0.02, p.head - up * 0.05, 0.055, 0.052, 12);
  }

  // Adds the head with nose and ears, hair or a helmet, and sometimes a hat.
  void head(const Pose& p) {
    s_.ball(skin_, p.head, {0.098, 0.078, 0.122}, 20);
    s_.ball(skin_, p.head + Vec3d{0.096, 0, -0.015}, {0.022, 0.014, 0.024}, 8);  // nose
    for (const double side : {-1.0, 1.0}) {
      s_.ball(skin_, p.head + Vec3d{-0.005, side * 0.077, -0.01}, {0.022, 0.012, 0.032}, 8);
    }
    const double thickness = c_.helmet ? 0.03 : 0.006;
    s_.ball(c_.helmet ? plastic_ : dark_, p.head + (c_.helmet ? Vec3d{-0.012, 0, 0.05} : Vec3d{-0.03, 0, 0.034}),
            {0.098 + thickness, 0.078 + thickness, 0.1 + thickness}, 18);
    if (c_.hat) {
      s_.revolve(dark_, at(p.head + Vec3d{0, 0, 0.06}),
                 {{0, 0}, {0.15, 0}, {0.15, 0.008}, {0.1, 0.012}, {0.09, 0.1}, {0, 0.11}}, 18);
    }
  }

  // Adds a leg and a shoe with a flat sole. `pitch`: rotation of the shoe about the ankle (rad).
  void leg(const Vec3d& hip, const Vec3d& ankle, double pitch) {
    const Vec3d knee = middleJoint(hip, ankle, 0.43, 0.43, {1, 0, 0.15});
    s_.pipe(lower_, {hip, hip + (knee - hip) * 0.35, knee, knee + (ankle - knee) * 0.35, ankle},
            {0.088 * c_.girth, 0.084 * c_.girth, 0.06, 0.06, 0.045}, 12);
    s_.ball(lower_, knee, {0.06, 0.06, 0.06}, 10);
    const double c = std::cos(pitch);
    const double s = std::sin(pitch);
    const Affine foot{{{c, 0, -s}, {0, 1, 0}, {s, 0, c}}, ankle};
    const Affine outer = s_.frame;
    s_.frame = outer * foot;
    s_.ball(plastic_, {0.05, 0, -0.035}, {0.135, 0.047, 0.045}, 12);
    s_.box(plastic_, {0.05, 0, -0.072}, {0.24, 0.075, 0.03});
    s_.ball(plastic_, {-0.02, 0, -0.01}, {0.055, 0.045, 0.06}, 10);
    s_.frame = outer;
  }

  void arm(const Vec3d& shoulder, const Vec3d& hand, const Vec3d& elbowDirection, double side) {
    const Vec3d elbow = middleJoint(shoulder, hand, 0.3, 0.27, elbowDirection + Vec3d{0, side * 0.45, 0});
    s_.ball(upper_, shoulder, {0.062, 0.058, 0.062}, 12);
    s_.pipe(upper_, {shoulder, shoulder + (elbow - shoulder) * 0.4, elbow, elbow + (hand - elbow) * 0.3, hand},
            {0.057, 0.054, 0.046, 0.045, 0.033}, 10);
    const Vec3d palm = hand + normalized(hand - elbow) * 0.06;
    s_.ball(skin_, palm, {0.045, 0.032, 0.055}, 10);
  }

  Shape& s_;
  const Clothes& c_;
  SurfaceIndex skin_, upper_, lower_, dark_, plastic_;
};

// Exchanges the person's left and right.
void mirror(Pose& p) {
  std::swap(p.leftAnkle, p.rightAnkle);
  std::swap(p.leftHand, p.rightHand);
  std::swap(p.leftPitch, p.rightPitch);
  for (Vec3d* v : {&p.leftAnkle, &p.rightAnkle, &p.leftHand, &p.rightHand}) v->y = -v->y;
}

// Returns the pose at a phase (rad) of a walking cycle: the left foot touches the ground in front of the body at 0 and
// leaves it at pi. `reach`, `swing`: amplitudes of feet and hands along x; `lean`: x of the shoulders (m).
Pose striding(double phase, double reach, double swing, double lean) {
  Pose p;
  p.hips.z = 0.89 + 0.02 * std::pow(std::sin(phase), 2);
  p.shoulders = {lean, 0, p.hips.z + 0.505};
  p.head = {lean * 1.2 + 0.02, 0, p.hips.z + 0.715};
  const auto setFoot = [&](double footPhase, double y, Vec3d& ankle, double& pitch) {
    const double backwards = (1 - std::cos(footPhase)) / 2;  // 0 in front of the body, 1 behind it
    const double lifted = std::sin(footPhase) < 0 ? 0.06 * std::pow(std::sin(footPhase), 2) : 0;
    ankle = {reach * std::cos(footPhase), y, 0.1 + 0.07 * backwards + lifted};
    pitch = -0.2 + 0.8 * backwards;
  };
  setFoot(phase, 0.08, p.leftAnkle, p.leftPitch);
  setFoot(phase + kPi, -0.08, p.rightAnkle, p.rightPitch);
  p.leftHand = {-swing * std::cos(phase), 0.26, p.hips.z - 0.03};
  p.rightHand = {swing * std::cos(phase), -0.26, p.hips.z - 0.03};
  return p;
}

// Returns the cloth of a garment. `dark`: share of black cloth among the rest, which is bright in the near infrared.
const char* drawCloth(Draw& draw, double dark) {
  constexpr double kDull = 0.35;  // share of cloth that is dark in the near infrared, too
  const double kind = draw.next();
  return kind < kDull ? "cloth_dull" : kind < kDull + (1 - kDull) * dark ? "cloth_dark" : "cloth";
}

// Returns random clothes of a pedestrian.
Clothes drawClothes(Draw& draw) {
  Clothes c;
  c.upper = drawCloth(draw, 0.5);
  c.lower = drawCloth(draw, 0.7);
  c.skirt = draw.chance(0.2);
  c.coat = !c.skirt && draw.chance(0.25);
  c.hat = draw.chance(0.2);
  c.backpack = draw.chance(0.3);
  c.bag = draw.chance(0.3);
  c.girth = draw.in(0.92, 1.15);
  return c;
}

// Builds a rider who sits on a vehicle and touches it at the points `fit`, in the vehicle's frame.
Model makeRider(SceneBuilder& builder, Draw draw, const RiderFit& fit, std::string_view className) {
  Shape s(builder, "rider");
  Pose p;
  p.hips = fit.saddle + Vec3d{0.02, 0, 0.1};
  const Vec3d grips = (fit.leftGrip + fit.rightGrip) * 0.5;
  const double lowBar = std::clamp(1.12 - grips.z, 0.0, 0.25);  // m by which the grips are too low to sit upright
  p.shoulders = p.hips + normalized(Vec3d{0.3 + lowBar * 1.4, 0, 1}) * 0.5;
  p.head = p.shoulders + Vec3d{0.08, 0, 0.2};
  p.leftAnkle = fit.leftPedal + Vec3d{-0.06, -0.02, 0.1};
  p.rightAnkle = fit.rightPedal + Vec3d{-0.06, 0.02, 0.1};
  p.rightPitch = 0.15;
  p.leftHand = fit.leftGrip + Vec3d{-0.04, 0, 0.02};
  p.rightHand = fit.rightGrip + Vec3d{-0.04, 0, 0.02};
  p.elbowDirection = {-0.4, 0, -0.8};
  Clothes c;
  c.upper = drawCloth(draw, 0.4);
  c.helmet = draw.chance(0.6);
  c.backpack = draw.chance(0.4);
  PersonMaker(s, className, c).make(p);
  return s.finish();
}

// Dimensions of an adult animal (m), by eye.
struct AnimalForm {
  double length;    // from chest to rump
  double height;    // height of the back above the ground
  double depth;     // from the back to the underside of the chest
  double width;     // half of the chest's width
  double neck;      // length of the neck
  double head;      // length of the head
  double leg;       // radius of a leg
  double tail;      // length of the tail
  double tailRise;  // slope of the tail: 1 points up, -1 hangs down
  double ear;       // length of an ear
};

constexpr std::array<AnimalForm, kAnimalForms> kForms{{
    {0.55, 0.55, 0.24, 0.11, 0.2, 0.2, 0.03, 0.3, 0.7, 0.07},     // dog
    {0.34, 0.34, 0.17, 0.08, 0.1, 0.13, 0.025, 0.15, 0.9, 0.05},  // small dog
    {0.3, 0.26, 0.12, 0.06, 0.08, 0.09, 0.017, 0.28, 0.8, 0.04},  // cat
    {1.5, 1.5, 0.65, 0.28, 0.8, 0.55, 0.07, 0.7, -0.9, 0.14},     // horse
    {1.6, 1.35, 0.75, 0.35, 0.5, 0.5, 0.08, 0.8, -1, 0.14},       // cow
    {0.9, 0.75, 0.45, 0.24, 0.25, 0.28, 0.035, 0.12, -1, 0.09},   // sheep
}};

}  // namespace

Model makePedestrian(SceneBuilder& builder, std::uint64_t seed, int form) {
  Draw draw(seed, Kind::Person, form);
  Shape s(builder, "pedestrian");
  Pose p;
  if (form % 2 == 0) {  // looks at a phone
    p.head = {0.06, 0, 1.62};
    p.rightHand = {0.3, -0.06, 1.24};
    p.leftAnkle.x = draw.in(-0.06, 0.06);
  } else {  // one hand on the hip
    p.leftHand = {0.06, 0.2, 1.02};
    p.leftAnkle = {0.08, 0.15, 0.09};
  }
  if (draw.chance(0.5)) mirror(p);
  const Clothes c = drawClothes(draw);
  s.frame = {Mat3::scale(Vec3d{1, 1, 1} * (draw.in(1.58, 1.9) / kPoseHeight)), {}};
  PersonMaker(s, "pedestrian", c).make(p);
  return s.finish();
}

Walker makeWalker(SceneBuilder& builder, std::uint64_t seed, int form) {
  constexpr int kMoments = 8;
  constexpr double kChildren = 0.12;  // fraction of the walkers
  Walker walker;
  for (int moment = 0; moment < kMoments; ++moment) {
    Draw draw(seed, Kind::Walker, form);
    Shape s(builder, "pedestrian");
    const double reach = draw.in(0.28, 0.34);
    const double swing = draw.in(0.18, 0.3);
    const Pose p = striding(2 * kPi * moment / kMoments, reach, swing, draw.in(0.02, 0.07));
    const Clothes c = drawClothes(draw);
    const double size = (draw.chance(kChildren) ? draw.in(1.15, 1.35) : draw.in(1.58, 1.9)) / kPoseHeight;
    s.frame = {Mat3::scale(Vec3d{1, 1, 1} * size), {}};
    PersonMaker(s, "pedestrian", c).make(p);
    walker.moments.push_back(s.finish());
    walker.stride = 4 * reach * size;
  }
  return walker;
}

Ridden makeCyclist(SceneBuilder& builder, std::uint64_t seed, int form) {
  RiderFit fit;
  const Model bicycle = makeBicycle(builder, seed, form, &fit);
  return {bicycle, makeRider(builder, {seed, Kind::Cyclist, form}, fit, "rider")};
}

Ridden makeMotorcyclist(SceneBuilder& builder, std::uint64_t seed, int form) {
  RiderFit fit;
  const Model motorcycle = makeMotorcycle(builder, seed, form, &fit);
  const Draw draw(seed, Kind::Motorcyclist, form);
  return {motorcycle, makeRider(builder, draw, fit, "motorcyclist")};
}

Model makeAnimal(SceneBuilder& builder, std::uint64_t seed, int form, int number) {
  const AnimalForm& f = kForms[static_cast<std::size_t>(form)];
  Draw draw(seed, Kind::Animal, form * 100 + number);
  const double size = draw.in(0.85, 1.12);  // factor on the size of an adult
  const bool grazes = form >= kPetForms && draw.chance(0.6);
  Shape s(builder, "animal");
  const SurfaceIndex coat = s.surface("animal", drawCloth(draw, 0.5));
  s.frame.linear = Mat3::scale(Vec3d{1, 1, 1} * size);
  const double middle = f.height - f.depth / 2;  // m, height of the trunk's axis
  const double half = f.length / 2;
  s.pipe(coat,
         {{-half - 0.08 * f.length, 0, middle + 0.1 * f.depth},
          {-half, 0, middle + 0.06 * f.depth},
          {-0.2 * f.length, 0, middle},
          {0.2 * f.length, 0, middle - 0.04 * f.depth},
          {half, 0, middle + 0.02 * f.depth},
          {half + 0.1 * f.length, 0, middle + 0.1 * f.depth}},
         {0.3 * f.width, 0.85 * f.width, 0.9 * f.width, f.width, 0.9 * f.width, 0.4 * f.width}, 12);
  s.ball(coat, {0.05 * f.length, 0, middle}, {0.5 * f.length, f.width, f.depth / 2}, 14);
  // The neck leads from the chest to the poll (the top of the head); the head leads from the poll along `face`.
  const Vec3d chest{half, 0, middle + 0.2 * f.depth};
  const Vec3d poll =
      chest + (grazes ? Vec3d{0.75 * f.neck, 0, -0.8 * f.height + 0.5 * f.head} : Vec3d{0.6 * f.neck, 0, 0.8 * f.neck});
  s.pipe(coat, {chest - Vec3d{0.1 * f.length, 0, 0.05 * f.depth}, chest, poll},
         {0.7 * f.width, 0.6 * f.width, 0.35 * f.width}, 10);
  const Vec3d face = grazes ? Vec3d{0.35, 0, -0.9} : Vec3d{0.95, 0, -0.3};
  s.pipe(coat, {poll - face * (0.15 * f.head), poll + face * (0.2 * f.head), poll + face * f.head},
         {0.3 * f.width, 0.42 * f.width, 0.24 * f.width}, 10);
  for (const double side : {-1.0, 1.0}) {  // an ear, a hind leg and a foreleg
    s.tube(coat, poll + Vec3d{0, side * 0.25 * f.width, 0.02}, poll + Vec3d{-0.2 * f.ear, side * 0.5 * f.width, f.ear},
           0.3 * f.ear, 0.08 * f.ear, 6);
    const double stride = draw.in(-0.16, 0.16) * f.height * (grazes ? 0.5 : 1);  // m, offset of a foot along x
    for (const double end : {-1.0, 1.0}) {
      const double x = end * (half - 0.06 * f.length);
      const double y = side * 0.6 * f.width;
      const double footX = x + stride * end * side;
      const double kneeZ = (middle - 0.3 * f.depth) * 0.5;
      s.pipe(coat, {{x, y, middle}, {(x + footX) / 2 + 0.03 * end * f.height, y, kneeZ}, {footX, y, 0}},
             {1.8 * f.leg, f.leg, 0.9 * f.leg}, 8);
    }
  }
  const Vec3d rump{-half - 0.08 * f.length, 0, middle + 0.25 * f.depth};
  s.pipe(coat,
         {rump, rump + Vec3d{-0.35 * f.tail, 0, 0.3 * f.tail * f.tailRise},
          rump + Vec3d{-0.5 * f.tail, 0, 0.9 * f.tail * f.tailRise}},
         {0.6 * f.leg, 0.5 * f.leg, 0.25 * f.leg}, 6);
  return s.finish();
}

}  // namespace scanmill::models
