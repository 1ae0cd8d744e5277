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
// length.
void hang(models::Shape& s, SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double sag, double radius) {
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

// A pole at its place. Its frame has the crossarm along y.
struct Standing {
  Affine place;
  double along = 0;  // m along the road
};

// True if lorries can pass under the wire from a to b wherever it crosses a road.
bool passesAbove(const Layout& l, const Vec3d& a, const Vec3d& b) {
  constexpr double kClear = 5;  // m, least height of a wire above a road
  constexpr int kPlaces = 24;
  for (int k = 0; k <= kPlaces; ++k) {
    const Vec3d p = a + (b - a) * (static_cast<double>(k) / kPlaces);
    const Beside beside = l.besideAt({p.x, p.y});
    if (beside.nearRoad && beside.edge < 0.5 && p.z < l.heightAt({p.x, p.y}) + kClear) return false;
  }
  return true;
}

// Places poles beyond the pavement, as evenly spaced as other objects allow.
std::vector<Standing> placePoles(Placer& placer, Draw& draw, const UtilityPole& pole) {
  const Layout& l = placer.layout;
  const Road& road = l.mainRoad();
  const double side = draw.sign();
  const double spacing = draw.in(32, 48);
  std::vector<Standing> poles;
  for (const double wanted : models::steps(l.mainFrom - 40 + draw.in(0, spacing), l.mainTo + 40, spacing)) {
    for (const double aside : {0.0, 2.5, -2.5, 5.0, -5.0, 8.0, -8.0}) {
      const double at = wanted + aside;
      if (at < 4 || at > road.length() - 4) continue;
      const double out = road.section.outer() + 0.45;
      const Spot spot = besideRoad(road, at, side * (road.section.half + out));
      const Beside b = l.besideAt(spot.at);
      if (!b.nearRoad || b.edge < out - 0.25 || l.areas.outsideHard(spot.at) < 0.3) continue;
      if (!placer.isFree({spot.at, 0.35, 0.35, spot.yaw})) continue;
      placer.occupancy.add({spot.at, 0.25, 0.25, spot.yaw});
      placer.put(pole.model, spot, fmt::format("utility pole {}", poles.size() + 1));
      poles.push_back({models::at(l.onGround(spot.at), spot.yaw), at});
      break;
    }
  }
  return poles;
}

}  // namespace

void placeWires(Placer& placer) {
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Wire);
  const Character& c = l.character;
  // Terraced streets and motorways have no poles: wires are underground, and there is no space between walls and road.
  const double share = c.farmland ? 0.7 : c.terraced || c.country || c.plain ? 0 : 0.4;
  if (!draw.chance(share)) return;
  const UtilityPole pole = models::makeUtilityPole(placer.builder, l.seed);
  const std::vector<Standing> poles = placePoles(placer, draw, pole);
  models::Shape s(placer.builder, "wires");
  const SurfaceIndex wire = s.surface("object", "rubber");
  const double slack = draw.in(0.00025, 0.0005);  // 1/m, sag divided by the square of the distance between poles
  int hung = 0;
  for (std::size_t i = 1; i < poles.size(); ++i) {
    const double apart = poles[i].along - poles[i - 1].along;
    if (apart > kFarthest) continue;
    for (const Vec3d& p : pole.insulators) {
      hang(s, wire, poles[i - 1].place * p, poles[i].place * p, slack * apart * apart, 0.006);
      ++hung;
    }
    hang(s, wire, poles[i - 1].place * pole.telephone, poles[i].place * pole.telephone, slack * apart * apart, 0.011);
  }
  for (const models::House& house : l.houses) {
    if (poles.empty() || !draw.chance(0.7)) continue;
    const Vec3d gable = house.pose * Vec3d{draw.in(0.2, 0.8) * house.width, -0.02, 2.7 * house.floors};
    const auto distance = [&](const Standing& p) { return length(p.place.translation - gable); };
    const auto nearest = std::min_element(
        poles.begin(), poles.end(), [&](const Standing& a, const Standing& b) { return distance(a) < distance(b); });
    if (distance(*nearest) > kToHouse || !passesAbove(l, nearest->place * pole.telephone, gable)) continue;
    hang(s, wire, nearest->place * pole.telephone, gable, 0.015 * distance(*nearest), 0.008);
    ++hung;
  }
  if (hung > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "wires");
}

}  // namespace scanmill::town
