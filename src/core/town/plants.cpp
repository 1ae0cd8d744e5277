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
constexpr double kOverhang = 0.5;   // m that crowns with a radius above 1.6 m may reach over a road
constexpr double kFar = 25;         // m from the nearest road, beyond which trees have fewer and larger leaves
constexpr double kFarDetail = 0.3;  // factor on the number of leaves of trees beyond kFar
constexpr int kBushForms = 6;
constexpr std::size_t kMostTrees = 900;  // largest number of trees in all woods together

// Returns a random model of a tree. All plants of a town share their models; a model is built when it is first needed.
const TreeModel& randomTree(Placer& placer, Draw& draw, bool broadleaf, bool far) {
  const int form = draw.below(broadleaf ? models::kBroadleafForms : models::kTreeForms);
  const int again = draw.below(kTreesOfAForm);
  std::optional<TreeModel>& made = placer.trees[{form, again, far}];
  if (!made) {
    const double detail = placer.layout.parameters.detail * (far ? kFarDetail : 1);
    made = models::makeTree(placer.builder, placer.layout.seed, form + again * models::kTreeForms, detail,
                            placer.layout.character.foliage, kRagged[static_cast<std::size_t>(again)]);
  }
  return *made;
}

// Plants a tree. Only the trunk needs free ground; crowns may overlap. Returns false if the place is not free, or if
// `room`, the largest radius of the crown (m; 0: not limited), is too small. The sizes that a map gives of the tree are
// kept.
bool plant(Placer& placer, Draw& draw, Spot spot, bool broadleaf, double room, const std::string& name,
           const MapTree& mapped = {}) {
  constexpr double kTrunkBelow = 0.05;  // m of the trunk below the ground
  const Beside b = placer.layout.besideAt(spot.at);
  const bool far = !b.nearRoad || b.edge > kFar;
  const TreeModel& tree = randomTree(placer, draw, broadleaf, far);
  spot.yaw = draw.in(0, 2 * kPi);
  spot.scale = draw.in(0.75, 1.35);
  // Near a road, limits the crown's radius so that it reaches at most kOverhang over the road, but not below 1.6 m.
  if (!far) room = std::min(room > 0 ? room : 1e9, std::max(1.6, b.edge + kOverhang));
  const double high = mapped.height.value_or(0) > 0 ? (*mapped.height + kTrunkBelow) / tree.model.bounds.high.z : 0;
  if (high > 0) spot.scale = high;
  if (room > 0) spot.scale = std::min(spot.scale, room / tree.crownRadius);
  if (mapped.crown) spot.scale = *mapped.crown / 2 / tree.crownRadius;
  const bool sized = mapped.height || mapped.crown;
  if ((spot.scale < 0.5 && !sized) || !placer.isFree({spot.at, 0.6, 0.6, 0})) return false;
  placer.occupancy.add({spot.at, 0.35, 0.35, 0});
  Affine place = models::poseOf(spot, placer.layout.heightAt(spot.at) - kTrunkBelow);
  if (high > 0) place.linear.z = {0, 0, high};
  placer.builder.place(tree.model.mesh, placer.worldFromTown * place, name);
  return true;
}

bool onLawn(const Layout& layout, const Point2& p, double beyond) {
  if (layout.areas.outsideHard(p) < 1) return false;
  const Beside b = layout.besideAt(p);
  return !b.nearRoad || b.edge > b.section.paved() + beyond;
}

// Places squares of soil in the pavement, in which trees stand.
void placePits(Placer& placer, const std::vector<Spot>& pits) {
  if (pits.empty()) return;
  constexpr double kHalf = 0.6;    // m, half of a pit's width
  constexpr double kAbove = 0.01;  // m above the pavement
  models::Shape s(placer.builder, "tree pits");
  const models::SurfaceIndex soil = s.surface("terrain", "soil");
  for (const Spot& pit : pits) {
    const Footprint square{pit.at, kHalf, kHalf, pit.yaw};
    const auto corner = [&](double u, double v) { return placer.layout.onGround(square.at(u, v), kAbove); };
    s.quad(soil, corner(-kHalf, -kHalf), corner(kHalf, -kHalf), corner(kHalf, kHalf), corner(-kHalf, kHalf));
  }
  placer.builder.place(s.finish().mesh, placer.worldFromTown, "tree pits");
}

// Plants trees along a road: in the verge if it is wide enough, in pits near the curb of wide sidewalks, else in the
// gardens behind the pavement. `avenue`: fraction of the places that have a tree. `number`: trees so far; it is
// advanced. Appends the spots in pits to `pits`.
void plantAlong(Placer& placer, const Road& road, double avenue, int& number, std::vector<Spot>& pits) {
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
      if (l.besideAt(spot.at).edge < out - 0.5) continue;  // the place is on another road or close to it
      const double room = std::clamp(out + kOverhang, 1.6, 3.4);
      if (!plant(placer, draw, spot, true, room, fmt::format("tree {}", number + 1))) continue;
      ++number;
      if (inPit) pits.push_back(spot);
    }
  }
}

// Plants trees in a park. `number`: see plantAlong().
void plantPark(Placer& placer, const MapArea& park, Draw& draw, int& number) {
  constexpr double kMost = 2000;  // trees
  const Layout& l = placer.layout;
  const Footprint about = rectangleAbout(park.outline);
  const double wanted = l.parameters.greenery * 4 * about.halfX * about.halfY / draw.in(70, 200);
  const int count = static_cast<int>(std::min(kMost, wanted));
  for (int k = 0; k < count; ++k) {
    const double u = draw.in(-about.halfX, about.halfX);
    const double v = draw.in(-about.halfY, about.halfY);
    const Point2 p = about.at(u, v);
    const bool far = !l.besideAt(p).nearRoad;
    if (far || l.areas.landAt(p) != Land::Park || !onLawn(l, p, 0.5)) continue;
    if (plant(placer, draw, {p, 0, 1, 0}, draw.chance(0.5), 0, fmt::format("tree {}", number + 1))) ++number;
  }
}

// Plants trees in the garden of a plot. `number`: see plantAlong().
void plantGarden(Placer& placer, const Plot& plot, int& number) {
  constexpr int kAttempts = 4;
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::GardenTrees, plot.number);
  const double expected = l.character.gardenTrees * draw.in(0.3, 1.7);
  const auto count = static_cast<int>(expected + draw.next());
  for (int k = 0; k < count; ++k) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const bool front = draw.chance(0.4) && plot.setback > 3;
      const double depth = front ? draw.in(0.8, plot.setback) : plot.setback + draw.in(0, 26);
      const Spot spot = l.inPlot(plot, draw.in(plot.from, plot.to), depth);
      if (!onLawn(l, spot.at, 0.5)) continue;
      if (!plant(placer, draw, spot, front, front ? 2.6 : 0, fmt::format("tree {}", number + 1))) continue;
      ++number;
      break;
    }
  }
}

constexpr int kForms = 6;
constexpr double kReach = 5;  // m; tufts are placed between the curb and this far beyond the sidewalk
constexpr int kMost = 2500;

// Builds a tuft of blades that bend outwards. No blade is higher than a random limit of 0.12 to 0.4 m.
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

void placeMapTrees(Placer& placer) {
  const Layout& l = placer.layout;
  std::uint32_t mapped = 0;
  bool lost = false;
  for (const MapTree& tree : l.trees) {
    Draw draw(l.seed, Kind::MapTree, mapped++);
    const Beside b = l.besideAt(tree.at);
    // Trees may be on a road, which is wider here than on the map.
    const bool onRoad = b.nearRoad && b.edge < 0.4;
    const Spot spot{tree.at, draw.in(0, 2 * kPi), 1, 0};
    if (onRoad || !plant(placer, draw, spot, true, 0, fmt::format("tree {}", mapped), tree)) lost = true;
  }
  // The text is the same for all places on the map, so that there is one warning.
  if (lost) {
    warn(fmt::format("{}: left out: trees where the town has roads, paths, houses or other trees",
                     l.parameters.map.string()));
  }
}

// Plants trees along the roads, in parks and in gardens, in this order. If the map has trees, none are added along the
// roads and in parks.
void placeTrees(Placer& placer) {
  const Layout& l = placer.layout;
  auto number = static_cast<int>(l.trees.size());
  std::vector<Spot> pits;
  for (const Road& road : l.roads()) {
    if (!road.minor) plantAlong(placer, road, l.trees.empty() ? l.character.avenue : 0, number, pits);
  }
  placePits(placer, pits);
  std::uint32_t area = 0;
  for (const MapArea& park : l.areas.list()) {
    Draw draw(l.seed, Kind::ParkTrees, ++area);
    if (park.land == Land::Park && l.trees.empty()) plantPark(placer, park, draw, number);
  }
  for (const Plot& plot : l.plots) plantGarden(placer, plot, number);
}

// Places woods: trees on a jittered lattice where a smooth random field is high, or in the woods of a map. Undergrowth
// grows between the trees and at the edge, where it forms a wall of leaves.
void placeWoods(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character;
  if (c.woods <= 0) return;
  const std::vector<Model> bushes = models::makeForms(
      4, [&](int f) { return models::makeUndergrowth(placer.builder, l.seed, f, l.character.foliage); });
  // The random `density` below exceeds this threshold on about the fraction `woods` of the land: its values are nearly
  // normal, with mean 0 and a standard deviation of a quarter.
  const double threshold = 0.42 * (1 - 2 * c.woods);
  Draw lattice(l.seed, Kind::WoodLattice);
  const double spacing = lattice.in(3.2, 4.6);
  const double reach = l.halfSide - 8;
  std::size_t trees = 0;
  std::uint32_t cell = 0;
  const std::vector<double> lines = models::steps(-reach, reach, spacing);
  for (const double y : lines) {
    for (const double x : lines) {
      Draw draw(l.seed, Kind::Wood, ++cell);
      const Spot spot{{x + draw.in(0, spacing), y + draw.in(0, spacing)}, draw.in(0, 2 * kPi), draw.in(0.7, 1.4), 0};
      const Beside b = l.besideAt(spot.at);
      // Skip places on a road or beside its sidewalk, and places far from all roads, which nearer trees would hide.
      if (!b.nearRoad || b.edge < b.section.outer() + std::max(b.section.apron, 0.4)) continue;
      const double density = relief({l.seed, Field::Woods}, spot.at.x, spot.at.y, 45) +
                             0.4 * relief({l.seed, Field::Clearings}, spot.at.x, spot.at.y, 12);
      const std::optional<Land> land = l.areas.landAt(spot.at);
      if (land ? *land != Land::Wood : density < threshold) continue;
      if (draw.chance(0.55)) {
        const Model& bush = draw.itemOf(bushes);
        if (placer.isFree({spot.at, 1.1, 1.1, 0})) {
          placer.occupancy.add({spot.at, 0.8, 0.8, 0});
          placer.put(bush, spot, fmt::format("undergrowth {}", cell), 0.05);
        }
      }
      if (trees >= kMostTrees || !draw.chance(0.6)) continue;
      const Spot beside{{spot.at.x + draw.in(-1.5, 1.5), spot.at.y + draw.in(-1.5, 1.5)}, 0, 1, 0};
      if (!onLawn(l, beside.at, 1)) continue;
      if (plant(placer, draw, beside, draw.chance(0.75), 0, fmt::format("wood {}", trees + 1))) ++trees;
    }
  }
}

void placeBushes(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character;
  if (c.gardenBushes <= 0) return;
  const double bushFoliage = std::max(c.foliage, 0.3);  // not below 0.3, since some bushes are evergreen
  const std::vector<Model> forms =
      models::makeForms(kBushForms, [&](int f) { return models::makeBush(placer.builder, l.seed, f, bushFoliage); });
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
      if (!placer.isFree({spot.at, 0.7 * spot.scale, 0.7 * spot.scale, 0})) continue;
      placer.occupancy.add({spot.at, 0.5 * spot.scale, 0.5 * spot.scale, 0});
      placer.put(bush, spot, fmt::format("bush {}", ++number), 0.03);
    }
  }
}

// Places tufts of unmown grass on verges and along the roads.
void placeGrass(Placer& placer) {
  const Layout& l = placer.layout;
  const Character& c = l.character;
  if (c.season == Season::Winter || c.plain) return;  // the grass is below the snow, or mown
  Draw place(l.seed, Kind::Grass);
  // `wild` is the density of tufts in a town: 0 if all grass is mown.
  const double wild = place.in(0, c.country ? 0.9 : c.terraced ? 0.2 : 0.45);
  const std::vector<Model> forms = models::makeForms(
      kForms, [&](int f) { return makeTuft(placer.builder, l.seed, f, c.season == Season::Autumn || f == 0); });
  int number = 0;
  std::uint32_t index = 0;
  for (const Road& road : l.roads()) {
    if (road.minor) continue;
    for (const double along : models::steps(3, road.length() - 3, 0.6)) {
      for (const double side : {-1.0, 1.0}) {
        Draw draw(l.seed, Kind::GrassAlongRoads, index++);
        const double out = road.section.curb + draw.in(0.05, road.section.outer() + kReach);
        Spot spot = besideRoad(road, along + draw.in(-0.3, 0.3), side * (road.section.half + out));
        // The density varies from place to place.
        const double share = wild * (0.5 + 2 * relief({l.seed, Field::Grass}, spot.at.x, spot.at.y, 18));
        if (number >= kMost || !draw.chance(share)) continue;
        const Beside b = l.besideAt(spot.at);
        const GroundKind kind = l.kindAt(b, spot.at);
        if (kind != GroundKind::Verge && kind != GroundKind::Shoulder && kind != GroundKind::Lawn) continue;
        if (!placer.isFree({spot.at, 0.1, 0.1, 0})) continue;
        spot.yaw = draw.in(0, 2 * kPi);
        spot.scale = draw.in(0.6, 1.4);
        placer.put(draw.itemOf(forms), spot, fmt::format("tuft {}", ++number));
      }
    }
  }
}

}  // namespace scanmill::town
