// Builds standing and grazing animals. Their trunk, neck, head, legs and tail are pipes.

#include <array>

#include "models/models.h"

namespace scanmill::models {
namespace {

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

Model makeAnimal(SceneBuilder& builder, std::uint64_t seed, int form, int number) {
  const AnimalForm& f = kForms[static_cast<std::size_t>(form)];
  Draw draw(seed, Kind::Animal, form * 100 + number);
  const double size = draw.in(0.85, 1.12);  // young animals are smaller
  const bool grazes = form >= kPetForms && draw.chance(0.6);
  Shape s(builder, "animal");
  const SurfaceIndex coat = s.surface("animal", draw.chance(0.5) ? "cloth" : "cloth_dark");
  s.frame.linear = Mat3::scale(Vec3d{1, 1, 1} * size);
  const double middle = f.height - f.depth / 2;  // height of the trunk's axis
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
  // The neck leads from the chest to the poll (the top of the head), the head from there in the direction of the face.
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
    const double stride = draw.in(-0.16, 0.16) * f.height * (grazes ? 0.5 : 1);  // m, of the foot along x
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
