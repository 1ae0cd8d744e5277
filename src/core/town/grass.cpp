// Places tufts of unmown grass on verges and along the roads.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;

constexpr int kForms = 6;
constexpr double kReach = 5;  // m; tufts are placed between the curb and this far beyond the sidewalk
constexpr int kMost = 2500;

// Builds a tuft of blades that bend outwards. No blade is higher than a random limit of 0.12 to 0.4 m.
Model makeTuft(SceneBuilder& builder, std::uint64_t seed, int form, bool dry) {
  Draw draw(seed, Kind::Tuft, static_cast<std::uint32_t>(form));
  models::Shape s(builder, "tuft of grass");
  const models::SurfaceIndex grass = s.surface("terrain", dry ? "grass_dry" : "grass");
  const double height = draw.in(0.12, 0.4);
  const double radius = draw.in(0.04, 0.14);
  const int blades = 24 + draw.below(30);
  for (int k = 0; k < blades; ++k) {
    const double angle = draw.in(0, 2 * kPi);
    const double out = radius * std::sqrt(draw.next());
    const double high = height * draw.in(0.4, 1);
    const double bend = high * draw.in(0.1, 0.7);
    const double half = draw.in(0.002, 0.005);
    const Vec3d outwards{std::cos(angle), std::sin(angle), 0};
    const Vec3d aside{-std::sin(angle) * half, std::cos(angle) * half, 0};
    const Vec3d foot = outwards * out + Vec3d{0, 0, -0.03};
    const Vec3d middle = foot + outwards * (0.35 * bend) + Vec3d{0, 0, 0.65 * high};
    const Vec3d tip = foot + outwards * bend + Vec3d{0, 0, high};
    s.quad(grass, foot - aside, foot + aside, middle + aside, middle - aside);
    s.triangle(grass, middle - aside, middle + aside, tip);
  }
  return s.finish();
}

}  // namespace

void placeGrass(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character();
  if (c.season == Season::Winter || c.plain) return;  // the grass is below the snow, or mown
  Draw place(l.seed(), Kind::Grass);
  // `wild` is the density of tufts in a town: 0 if all grass is mown.
  const double wild = place.in(0, c.country ? 0.9 : c.terraced ? 0.2 : 0.45);
  const std::vector<Model> forms = models::makeForms(
      kForms, [&](int f) { return makeTuft(placer.builder, l.seed(), f, c.season == Season::Autumn || f == 0); });
  int number = 0;
  std::uint32_t index = 0;
  for (std::uint32_t r = 0; r < l.roads().roads().size(); ++r) {
    const Road& road = l.roads().roads()[r];
    if (road.minor) continue;
    for (const double along : models::steps(3, road.length() - 3, 0.6)) {
      for (const double side : {-1.0, 1.0}) {
        Draw draw(l.seed(), Kind::GrassAlongRoads, index++);
        const double out = road.section.curb + draw.in(0.05, road.section.outer() + kReach);
        Spot spot = besideRoad(road, along + draw.in(-0.3, 0.3), side * (road.section.half + out));
        // The density varies from place to place.
        const double share = wild * (0.5 + 2 * relief({l.seed(), Field::Grass}, spot.at.x, spot.at.y, 18));
        if (number >= kMost || !draw.chance(share)) continue;
        const Beside b = l.roads().at(spot.at.x, spot.at.y);
        const GroundKind kind = l.kindAt(b, spot.at);
        if (kind != GroundKind::Verge && kind != GroundKind::Shoulder && kind != GroundKind::Lawn) continue;
        if (!placer.isFree({spot.at, 0.1, 0.1, 0})) continue;
        spot.yaw = draw.in(0, 2 * kPi);
        spot.scale = draw.in(0.6, 1.4);
        placer.put(draw.of(forms), spot, fmt::format("tuft {}", ++number));
      }
    }
  }
}

}  // namespace scanmill::town
