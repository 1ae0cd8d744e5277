// Places trees, bushes and undergrowth along roads, in gardens and in woods.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;
using models::TreeModel;

constexpr int kTreesOfAForm = 2;
constexpr std::array<double, kTreesOfAForm> kRagged{0.6, 1};  // irregularity of the crowns: see makeTree()
constexpr double kOverhang = 0.5;   // m by which crowns above kLeastCrown may extend over a road
constexpr double kFar = 25;         // m from the nearest road; trees beyond have fewer and larger leaves
constexpr double kFarDetail = 0.3;  // factor on the number of leaves of trees beyond kFar
constexpr int kBushForms = 6;
constexpr std::size_t kMostTrees = 900;  // largest number of trees in all woods together

enum class Trees { Broadleaf, Any };

// Returns a random tree model, with less detail if `far`. A town's trees share a few models, built on demand.
const TreeModel& randomTree(Placer& placer, Draw& draw, Trees kind, bool far) {
  const int form = draw.below(kind == Trees::Broadleaf ? models::kBroadleafForms : models::kTreeForms);
  const int variant = draw.below(kTreesOfAForm);
  std::optional<TreeModel>& tree = placer.trees[{form, variant, far}];
  if (!tree) {
    const double detail = placer.layout.parameters.detail * (far ? kFarDetail : 1);
    tree = models::makeTree(placer.builder, placer.layout.seed, form + variant * models::kTreeForms, detail,
                            placer.layout.character.foliage, kRagged[static_cast<std::size_t>(variant)]);
  }
  return *tree;
}

// Plants a tree of a random form, size and yaw. Only the trunk needs free ground; crowns may overlap. `largestCrown`:
// limit of the crown's radius (m). `mapped`: height and crown on the map, which replace random sizes. Returns false if
// the spot is not free, or if the limits of the crown would scale the model by less than 0.5.
bool plant(Placer& placer, Draw& draw, Spot spot, Trees kind, double largestCrown, const std::string& name,
           const MapTree& mapped = {}) {
  constexpr double kTrunkBelow = 0.05;  // m of the trunk below the ground
  constexpr double kHalfFree = 0.6,
                   kHalfTrunk = 0.35;  // m, half sides of the squares that must be free and that are then occupied
  constexpr double kLeastCrown = 1.6;  // m, radius up to which roads do not limit a crown
  const Beside b = placer.layout.besideAt(spot.at);
  const bool far = !b.nearRoad || b.edge > kFar;
  const TreeModel& tree = randomTree(placer, draw, kind, far);
  spot.yaw = draw.in(0, 2 * kPi);
  spot.scale = draw.in(0.75, 1.35);
  // The mapped height scales the model in all directions. The limits of the crown reduce the horizontal scale alone,
  // and the mapped crown replaces it.
  std::optional<double> heightScale;
  if (mapped.height.value_or(0) > 0) heightScale = (*mapped.height + kTrunkBelow) / tree.model.bounds.high.z;
  if (!far) largestCrown = std::min(largestCrown, std::max(kLeastCrown, b.edge + kOverhang));
  spot.scale = std::min(heightScale.value_or(spot.scale), largestCrown / tree.crownRadius);
  if (mapped.crown) spot.scale = *mapped.crown / 2 / tree.crownRadius;
  const bool sizeMapped = mapped.height || mapped.crown;
  if ((spot.scale < 0.5 && !sizeMapped) || !placer.isFree(Footprint::square(spot.at, kHalfFree))) return false;
  placer.occupancy.add(Footprint::square(spot.at, kHalfTrunk));
  Affine pose = models::poseOf(spot, placer.layout.heightAt(spot.at) - kTrunkBelow);
  if (heightScale) pose.linear.z = {0, 0, *heightScale};
  placer.builder.place(tree.model.mesh, placer.worldFromTown * pose, name);
  return true;
}

// Plants a tree with the name "tree NUMBER"; see plant().
bool plantNumbered(Placer& placer, Draw& draw, const Spot& spot, Trees kind, double largestCrown) {
  return placer.tryNumbered(
      "tree", [&](const std::string& name) { return plant(placer, draw, spot, kind, largestCrown, name); });
}

// True if a point is at least `beyond` m from pavements and at least 1 m from parking lots, squares and water.
bool onLawn(const Layout& layout, const Point2& p, double beyond) {
  if (layout.areas.outsideHard(p) < 1) return false;
  const Beside b = layout.besideAt(p);
  return !b.nearRoad || b.edge > b.section.paved() + beyond;
}

// Places a square of soil in the pavement around the trunk of each tree at `pits`.
void placePits(Placer& placer, const std::vector<Spot>& pits) {
  if (pits.empty()) return;
  constexpr double kHalf = 0.6;    // m, half of a pit's width
  constexpr double kAbove = 0.01;  // m above the pavement
  models::Shape s(placer.builder, "tree pits");
  const models::SurfaceIndex soil = s.surface("terrain", "soil");
  for (const Spot& pit : pits) {
    const Polygon corners = cornersOf(Footprint::square(pit.at, kHalf, pit.yaw));
    const auto corner = [&](std::size_t k) { return placer.layout.onGround(corners[k], kAbove); };
    s.quad(soil, corner(0), corner(1), corner(2), corner(3));
  }
  placer.putShape(s);
}

// Plants trees along a road: in a wide verge, else in pits near the curb of a wide sidewalk, else in the gardens behind
// the pavement. `avenue`: fraction of the positions that have a tree. Appends the spots of trees in pits to `pits`.
void plantAlong(Placer& placer, const Road& road, double avenue, std::vector<Spot>& pits) {
  constexpr double kWideVerge = 1.2, kWideSidewalk = 2.8;  // m
  const Layout& l = placer.layout;
  const CrossSection& s = road.section;
  const bool inVerge = s.verge > kWideVerge;
  const bool inPit = !inVerge && s.sidewalk > kWideSidewalk;
  Draw draw(l.seed, Kind::Avenue, road.number);
  const double spacing = draw.in(7, 13);
  for (const double along : models::steps(6, road.length() - 4, spacing)) {
    for (const int side : {-1, 1}) {
      if (!draw.chance(avenue)) continue;
      const double out = inVerge ? s.curb + s.verge / 2
                         : inPit ? s.curb + draw.in(0.9, 1.1)
                                 : s.outer() + draw.in(0.8, 2.5);
      const Spot spot = besideRoad(road, along + draw.in(-1, 1), side * (s.half + out));
      if (l.besideAt(spot.at).edge < out - 0.5) continue;  // the spot is on another road or close to it
      const double largestCrown = std::clamp(out + kOverhang, 1.6, 3.4);
      if (plantNumbered(placer, draw, spot, Trees::Broadleaf, largestCrown) && inPit) pits.push_back(spot);
    }
  }
}

// Tries one random position per 70 to 200 m^2 of a park's bounding rectangle, and plants trees on the park's lawn.
void plantPark(Placer& placer, const MapArea& park, Draw& draw) {
  constexpr double kMost = 2000;  // trees
  const Layout& l = placer.layout;
  const Footprint about = rectangleAbout(park.outline);
  const double expected = l.parameters.greenery * 4 * about.halfX * about.halfY / draw.in(70, 200);
  const int count = static_cast<int>(std::min(kMost, expected));
  for (int k = 0; k < count; ++k) {
    const double u = draw.in(-about.halfX, about.halfX);
    const double v = draw.in(-about.halfY, about.halfY);
    const Point2 p = about.at(u, v);
    const bool far = !l.besideAt(p).nearRoad;
    if (far || l.areas.landAt(p) != Land::Park || !onLawn(l, p, 0.5)) continue;
    plantNumbered(placer, draw, {.at = p}, draw.chance(0.5) ? Trees::Broadleaf : Trees::Any, INFINITY);
  }
}

// Plants trees in the garden of a plot.
void plantGarden(Placer& placer, const Plot& plot) {
  constexpr int kAttempts = 4;
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::GardenTrees, plot.number);
  const bool courts = l.character.terraced;  // true: trees may stand on the paved ground behind the houses
  const double expected = l.character.gardenTrees * draw.in(0.3, 1.7);
  const auto count = static_cast<int>(expected + draw.next());
  for (int k = 0; k < count; ++k) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const bool front = draw.chance(0.4) && plot.setback > 3;
      const double depth = front ? draw.in(0.8, plot.setback) : plot.setback + draw.in(0, courts ? 60 : 26);
      const Spot spot = l.inPlot(plot, draw.in(plot.from, plot.to), depth);
      const bool inCourt = courts && depth > plot.setback + plot.depth && !l.besideAt(spot.at).isOnRoadOrSidewalk(8);
      if (!inCourt && !onLawn(l, spot.at, 0.5)) continue;
      if (plantNumbered(placer, draw, spot, front ? Trees::Broadleaf : Trees::Any, front ? 2.6 : INFINITY)) break;
    }
  }
}

// Builds a tuft of grass with blades that bend outwards. The largest height of the blades is random, 0.12 to 0.4 m.
Model makeTuft(SceneBuilder& builder, std::uint64_t seed, int form, bool dry) {
  Draw draw(seed, Kind::Tuft, form);
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

// Plants the trees of the map. Warns if some are left out.
void placeMapTrees(Placer& placer) {
  constexpr double kFromRoad = 0.4;  // m, least distance between a trunk and a road
  const Layout& l = placer.layout;
  std::uint32_t treeNumber = 0;
  bool leftOut = false;
  for (const MapTree& tree : l.trees) {
    Draw draw(l.seed, Kind::MapTree, treeNumber++);
    const Beside b = l.besideAt(tree.at);
    // A tree may be on a road that is wider in the town than on the map.
    const bool onRoad = b.nearRoad && b.edge < kFromRoad;
    draw.next();  // unused, since plant() draws the yaw; without it, the same seed would give other trees
    const std::string name = fmt::format("tree {}", treeNumber);
    leftOut |= onRoad || !plant(placer, draw, {.at = tree.at}, Trees::Broadleaf, INFINITY, name, tree);
  }
  // The text is the same for all towns on the map, because warn() reports equal texts only once.
  if (leftOut) {
    warn("{}: left out: trees where the town has roads, paths, houses or other trees", l.parameters.map.string());
  }
}

// Plants trees along the roads, in parks and in gardens, in this order. If the map has trees, plants only in gardens.
void placeTrees(Placer& placer) {
  const Layout& l = placer.layout;
  placer.numbers["tree"] = static_cast<int>(l.trees.size());  // continues the numbers of the map's trees
  std::vector<Spot> pits;
  for (const Road& road : l.roads()) {
    if (!road.minor) plantAlong(placer, road, l.trees.empty() ? l.character.avenue : 0, pits);
  }
  placePits(placer, pits);
  std::uint32_t areaNumber = 0;
  for (const MapArea& park : l.areas.list()) {
    Draw draw(l.seed, Kind::ParkTrees, ++areaNumber);
    if (park.land == Land::Park && l.trees.empty()) plantPark(placer, park, draw);
  }
  for (const Plot& plot : l.plots) plantGarden(placer, plot);
}

// Places trees and undergrowth on a jittered lattice: in areas of wood and, outside all areas, where `density` is high.
void placeWoods(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character;
  if (c.woods <= 0) return;
  const std::vector<Model> bushes = placer.forms(4, models::makeUndergrowth, c.foliage);
  // `density` (see below) is nearly normal, with mean 0 and standard deviation 1/4. It exceeds the threshold on about
  // the fraction `woods` of the land: the threshold is a linear approximation of the quantile.
  const double threshold = 0.42 * (1 - 2 * c.woods);
  constexpr double kWoodSize = 45, kClearingSize = 12, kClearings = 0.4;  // m, m, weight; chosen by eye
  Draw lattice(l.seed, Kind::WoodLattice);
  const double spacing = lattice.in(3.2, 4.6);
  const double reach = l.halfSide - 8;
  std::size_t trees = 0;
  std::uint32_t cell = 0;
  const std::vector<double> coordinates = models::steps(-reach, reach, spacing);
  for (const double y : coordinates) {
    for (const double x : coordinates) {
      Draw draw(l.seed, Kind::Wood, ++cell);
      const Spot spot{{x + draw.in(0, spacing), y + draw.in(0, spacing)}, draw.in(0, 2 * kPi), draw.in(0.7, 1.4), 0};
      const Beside b = l.besideAt(spot.at);
      // Skips spots at a road or sidewalk, and spots far from all roads, where nearer trees would hide a tree.
      if (!b.nearRoad || b.isOnRoadOrSidewalk(std::max(b.section.apron, 0.4))) continue;
      const double density = relief({l.seed, Field::Woods}, spot.at.x, spot.at.y, kWoodSize) +
                             kClearings * relief({l.seed, Field::Clearings}, spot.at.x, spot.at.y, kClearingSize);
      const std::optional<Land> land = l.areas.landAt(spot.at);
      if (land ? *land != Land::Wood : density < threshold) continue;
      if (l.kindAt(b, spot.at) == GroundKind::Paved) continue;
      if (draw.chance(0.55)) {
        const Model& bush = draw.itemOf(bushes);
        if (placer.isFree(Footprint::square(spot.at, 1.1))) {
          placer.occupancy.add(Footprint::square(spot.at, 0.8));
          placer.put(bush, spot, fmt::format("undergrowth {}", cell), 0.05);
        }
      }
      if (trees >= kMostTrees || !draw.chance(0.6)) continue;
      const Spot treeSpot{.at = {spot.at.x + draw.in(-1.5, 1.5), spot.at.y + draw.in(-1.5, 1.5)}};
      if (!onLawn(l, treeSpot.at, 1)) continue;
      const Trees kind = draw.chance(0.75) ? Trees::Broadleaf : Trees::Any;
      if (plant(placer, draw, treeSpot, kind, INFINITY, fmt::format("wood {}", trees + 1))) ++trees;
    }
  }
}

// Places bushes in the gardens, in front of houses and behind houses.
void placeBushes(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character;
  if (c.gardenBushes <= 0) return;
  const double bushFoliage = std::max(c.foliage, 0.3);  // at least 0.3, since some bushes are evergreen
  const std::vector<Model> forms = placer.forms(kBushForms, models::makeBush, bushFoliage);
  int number = 0;
  for (const Plot& plot : l.plots) {
    Draw draw(l.seed, Kind::GardenBushes, plot.number);
    const double expected = c.gardenBushes * draw.in(0.2, 1.8);
    const int count = static_cast<int>(expected + draw.next());
    for (int k = 0; k < count; ++k) {
      const double depth = draw.chance(0.4) ? draw.in(0.4, std::max(1.0, 0.5 * plot.setback)) : draw.in(14, 26);
      Spot spot = l.inPlot(plot, draw.in(plot.from, plot.to), depth);
      spot.yaw = draw.in(0, 2 * kPi);
      spot.scale = draw.in(0.6, 1.5);
      if (!onLawn(l, spot.at, 0.4 * spot.scale)) continue;
      const Model& bush = draw.itemOf(forms);
      if (!placer.isFree(Footprint::square(spot.at, 0.7 * spot.scale))) continue;
      placer.occupancy.add(Footprint::square(spot.at, 0.5 * spot.scale));
      placer.put(bush, spot, fmt::format("bush {}", ++number), 0.03);
    }
  }
}

// Places tufts of unmown grass on verges and along the roads.
void placeGrass(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character;
  if (c.season == Season::Winter || c.plain) return;  // the grass is below the snow, or mown
  constexpr int kTuftForms = 6, kMostTufts = 2500;
  constexpr double kReach = 5;  // m; tufts are placed from the curb to this distance beyond the sidewalk
  // The mean probability of a tuft at a position along the roads: 0 if all grass is mown.
  const double meanDensity = Draw(l.seed, Kind::Grass).in(0, c.country ? 0.9 : c.terraced ? 0.2 : 0.45);
  const auto tufts = placer.forms(kTuftForms, [&](SceneBuilder& builder, std::uint64_t seed, int form) {
    return makeTuft(builder, seed, form, c.season == Season::Autumn || form == 0);
  });
  int number = 0;
  std::uint32_t index = 0;
  for (const Road& road : l.roads()) {
    if (road.minor) continue;
    for (const double along : models::steps(3, road.length() - 3, 0.6)) {
      for (const double side : {-1.0, 1.0}) {
        Draw draw(l.seed, Kind::GrassAlongRoads, index++);
        const double out = road.section.curb + draw.in(0.05, road.section.outer() + kReach);
        Spot spot = besideRoad(road, along + draw.in(-0.3, 0.3), side * (road.section.half + out));
        const double density = meanDensity * (0.5 + 2 * relief({l.seed, Field::Grass}, spot.at.x, spot.at.y, 18));
        if (number >= kMostTufts || !draw.chance(density)) continue;
        const Beside b = l.besideAt(spot.at);
        const GroundKind kind = l.kindAt(b, spot.at);
        if (kind != GroundKind::Verge && kind != GroundKind::Shoulder && kind != GroundKind::Lawn) continue;
        if (!placer.isFree(Footprint::square(spot.at, 0.1))) continue;
        spot.yaw = draw.in(0, 2 * kPi);
        spot.scale = draw.in(0.6, 1.4);
        placer.put(draw.itemOf(tufts), spot, fmt::format("tuft {}", ++number));
      }
    }
  }
}

}  // namespace scanmill::town
