// Places wooden poles along the main road, wires between them, and wires to the houses.

#include <fmt/format.h>

#include <algorithm>

#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;
using models::SurfaceIndex;
using models::UtilityPole;

constexpr double kFarthest = 60;  // m, largest distance between two poles that a wire connects
constexpr double kToHouse = 26;   // m, largest distance between a pole and a house that a wire connects

// Adds a wire between two points as a parabola, which is close to a catenary if the sag is only a few hundredths of the
// length. `sag`: at its middle (m).
void addWire(models::Shape& s, SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double sag, double radius) {
  constexpr int kPieces = 16;
  std::vector<Vec3d> points;
  for (int k = 0; k <= kPieces; ++k) {
    const double t = static_cast<double>(k) / kPieces;
    Vec3d p = a + (b - a) * t;
    p.z -= 4 * sag * t * (1 - t);
    points.push_back(p);
  }
  s.pipe(surface, points, std::vector<double>(points.size(), radius), 5);
}

struct PlacedPole {
  Affine pose;       // in the town's frame
  double along = 0;  // m along the road
};

// True if lorries can pass under a straight wire from a to b wherever it crosses a road.
bool passesAbove(const Layout& l, const Vec3d& a, const Vec3d& b) {
  constexpr double kClear = 5;  // m, least height of a wire above a road
  constexpr int kSamples = 24;
  for (int k = 0; k <= kSamples; ++k) {
    const Vec3d p = a + (b - a) * (static_cast<double>(k) / kSamples);
    const Beside beside = l.besideAt({p.x, p.y});
    if (beside.nearRoad && beside.edge < 0.5 && p.z < l.heightAt({p.x, p.y}) + kClear) return false;
  }
  return true;
}

// Places poles beyond the pavement at one side of the main road, as evenly spaced as other objects allow.
std::vector<PlacedPole> placePoles(Placer& placer, Draw& draw, const UtilityPole& pole) {
  const Layout& l = placer.layout;
  const Road& road = l.mainRoad();
  const double side = draw.sign();
  const double spacing = draw.in(32, 48);
  std::vector<PlacedPole> poles;
  const double out = road.section.outer() + 0.45;  // m beyond the road's edge
  for (const double ideal : models::steps(l.mainFrom - 40 + draw.in(0, spacing), l.mainTo + 40, spacing)) {
    for (const double shift : {0.0, 2.5, -2.5, 5.0, -5.0, 8.0, -8.0}) {
      const double along = ideal + shift;
      if (along < 4 || along > road.length() - 4) continue;
      const Spot spot = besideRoad(road, along, side * (road.section.half + out));
      const Beside b = l.besideAt(spot.at);
      if (!b.nearRoad || b.edge < out - 0.25 || l.areas.outsideHard(spot.at) < 0.3) continue;
      if (!placer.isFree(models::squareAbout(spot.at, 0.35, spot.yaw))) continue;
      placer.occupancy.add(models::squareAbout(spot.at, 0.25, spot.yaw));
      placer.put(pole.model, spot, fmt::format("utility pole {}", poles.size() + 1));
      poles.push_back({models::at(l.onGround(spot.at), spot.yaw), along});
      break;
    }
  }
  return poles;
}

}  // namespace

// Places poles in some towns, wires between successive poles, and wires from the nearest pole to most houses.
void placeWires(Placer& placer) {
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Wire);
  const Character& c = l.character;
  // Terraced streets and motorways have no poles: wires are underground, and there is no space between walls and road.
  const double probability = c.farmland ? 0.7 : c.terraced || c.country || c.plain ? 0 : 0.4;
  if (!draw.chance(probability)) return;
  const UtilityPole pole = models::makeUtilityPole(placer.builder, l.seed);
  const std::vector<PlacedPole> poles = placePoles(placer, draw, pole);
  models::Shape s(placer.builder, "wires");
  const SurfaceIndex rubber = s.surface("object", "rubber");
  const double slack = draw.in(0.00025, 0.0005);  // 1/m, sag divided by the square of the distance between poles
  for (std::size_t i = 1; i < poles.size(); ++i) {
    const double distance = poles[i].along - poles[i - 1].along;
    if (distance > kFarthest) continue;
    const double sag = slack * distance * distance;
    for (const Vec3d& p : pole.insulators) addWire(s, rubber, poles[i - 1].pose * p, poles[i].pose * p, sag, 0.006);
    addWire(s, rubber, poles[i - 1].pose * pole.telephone, poles[i].pose * pole.telephone, sag, 0.011);
  }
  for (const models::House& house : l.houses) {
    if (poles.empty() || !draw.chance(0.7)) continue;
    const Vec3d gable = house.pose * Vec3d{draw.in(0.2, 0.8) * house.width, -0.02, 2.7 * house.floors};
    const auto distance = [&](const PlacedPole& p) { return length(p.pose.translation - gable); };
    const PlacedPole& nearest = *std::ranges::min_element(poles, {}, distance);
    const Vec3d start = nearest.pose * pole.telephone;
    if (distance(nearest) > kToHouse || !passesAbove(l, start, gable)) continue;
    addWire(s, rubber, start, gable, 0.015 * distance(nearest), 0.008);
  }
  if (!s.mesh.triangles.empty()) placer.putShape(s);
}

}  // namespace scanmill::town
