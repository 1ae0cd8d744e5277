// Places roadworks, crossings, traffic lights, objects in gardens and on squares, and animals.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Clutter;
using models::Kind;
using models::Shape;

// Returns one of three models of a kind of clutter, at random.
const Model& anyClutter(Placer& placer, Clutter what, Draw& draw) {
  constexpr int kForms = 3;
  const int form = draw.below(kForms);
  return placer.model(Kind::Clutter, static_cast<int>(what) * kForms + form,
                      [&] { return models::makeClutter(placer.builder, placer.layout.seed, what, form); });
}

// Returns the start (m along the main road) of a random interval of `length` m without junctions; nullopt: none found.
std::optional<double> drawFreeStretch(const Layout& l, Draw& draw, double length) {
  constexpr double kFromEnds = 25;  // m from the ends of the built-up part
  const Road& road = l.mainRoad();
  for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
    const double start = draw.in(l.mainFrom + kFromEnds, l.mainTo - kFromEnds - length);
    const auto isJunction = [&](double along) {
      return l.besideAt(road.point(along)).edge <= -road.section.half - 0.2;
    };
    if (std::ranges::none_of(models::steps(start, start + length + 2, 2), isJunction)) return start;
  }
  return std::nullopt;
}

// Places two lights beside a road: at `first` (m along the road) for vehicles that drive in the direction of the road's
// line, at `last` for vehicles that drive against the line. `marked`: true if the lights have stop lines.
void putLights(Placer& placer, const Model& light, const Road& road, double first, double last, bool marked,
               const std::string& name) {
  const double out = road.section.half + road.section.curb + 0.45;
  Spot spot = besideRoad(road, first, -out);
  spot.yaw += kPi;
  placer.tryPut(light, spot, name + ", with the line");
  placer.tryPut(light, besideRoad(road, last, out), name + ", against the line");
  Draw draw(placer.layout.seed, Kind::LightPhase, placer.lights.size());
  placer.lights.push_back({.stopAgainstLine = last + 1,
                           .stopWithLine = first - 1,
                           .offset = draw.in(0, Placer::Light::kPeriod),
                           .marked = marked});
}

// True if the ground is level enough for a wide object: heights at four points around `p` differ by less than kLargest.
bool isLevel(const Layout& l, const Point2& p) {
  constexpr double kAround = 1.2, kLargest = 0.35;  // m
  std::vector<double> heights;
  for (const Point2& corner : cornersOf(Footprint::square(p, kAround))) heights.push_back(l.heightAt(corner));
  const auto [low, high] = std::ranges::minmax(heights);
  return high - low < kLargest;
}

// Places roadworks with an excavator and cones on the left lane of the main road; the ego vehicle uses the right lane.
void placeRoadworks(Placer& placer, const Model& light) {
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Roadworks);
  const bool rural = l.character.country;
  const Road& road = l.mainRoad();
  // One-way roads have only the lane that the ego vehicle needs; motorways have no roadworks either.
  if (road.oneWay() || l.character.motorway) return;
  if (!draw.chance(rural ? 0.5 : 0.3)) return;
  const double length = draw.in(9, 18);
  const std::optional<double> start = drawFreeStretch(l, draw, length);
  if (!start) return;
  const double edge = road.section.half - road.section.parking;  // m to the left of the road's line
  const auto put = [&](const Model& m, double along, double lateral, double yaw, const std::string& name) {
    Spot spot = besideRoad(road, *start + along, lateral);
    spot.yaw += yaw;
    placer.tryPark(m, spot, name);
  };
  if (l.parameters.vehicles > 0) {
    const Model excavator = models::makeWorkVehicle(placer.builder, l.seed, models::WorkVehicle::Excavator, 0);
    put(excavator, 0.4 * length, std::max(edge - 1.3, 1.6), draw.chance(0.5) ? 0 : kPi, "excavator");
  }
  put(anyClutter(placer, Clutter::Heap, draw), 0.8 * length, std::max(edge - 1.1, 2.0), 0, "heap");
  const Clutter goods = draw.chance(0.5) ? Clutter::Pallets : Clutter::Skip;
  put(anyClutter(placer, goods, draw), 1.5, edge - 1.1, 0, "roadworks' goods");
  const Model& barrier = anyClutter(placer, Clutter::Barrier, draw);
  const double barrierLateral = std::max(edge - 1.2, 1.4);
  put(barrier, -0.6, barrierLateral, kPi / 2, "barrier 1");
  put(barrier, length + 0.6, barrierLateral, kPi / 2, "barrier 2");
  int coneNumber = 0;
  for (const double along : models::steps(0, length, draw.in(2, 3))) {
    const Model& cone = anyClutter(placer, Clutter::Cone, draw);
    const double lateral = std::max(edge - 2.6, 0.45) + draw.in(-0.1, 0.1);
    put(cone, along, lateral, draw.in(0, 1), fmt::format("cone {}", ++coneNumber));
  }
  if (rural || draw.chance(0.4)) {
    putLights(placer, light, road, *start - 6, *start + length + 6, false, "roadworks' light");
  }
}

// Places a pedestrian crossing on the main road: stripes and lights.
void placeCrossing(Placer& placer, const Model& light) {
  constexpr double kLength = 3;                         // m along the road
  constexpr double kStripe = 0.5, kStripeDistance = 1;  // m, width of a stripe; m between the starts of two stripes
  constexpr double kFreeOfCars = 4;                     // m; vehicles do not park closer to the crossing
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Crossing);
  const std::optional<double> start = drawFreeStretch(l, draw, kLength);
  if (!start) return;
  const Road& road = l.mainRoad();
  const Spot middle = besideRoad(road, *start + kLength / 2, 0);
  const Footprint keptFree{middle.at, kLength / 2 + kFreeOfCars, road.section.half, middle.yaw};
  if (!placer.isFree(keptFree)) return;
  placer.noParking.add(keptFree);
  Shape s(placer.builder, "crossing");
  const models::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  const double half = road.section.half - 0.3;
  for (const double lateral : models::steps(-half, half - kStripe, kStripeDistance)) {
    constexpr int kPieces = 3;  // number of pieces of a stripe; pieces follow the ground
    for (int piece = 0; piece < kPieces; ++piece) {
      const auto along = [&](int k) { return *start + kLength * k / kPieces; };
      paintBar(s, paint, l, road, {along(piece), along(piece + 1)}, {lateral, lateral + kStripe});
    }
  }
  placer.putShape(s);
  putLights(placer, light, road, *start - 1, *start + kLength + 1, true, "crossing's light");
}

// Places traffic lights at some of the junctions between the main road and side roads.
void placeSignals(Placer& placer, const Model& light) {
  const Layout& l = placer.layout;
  for (const Road& side : l.roads()) {
    Draw draw(l.seed, Kind::Signals, side.number);
    if (!draw.chance(l.character.lights) || !side.joins) continue;
    const double away = side.section.half + 5;
    putLights(placer, light, l.mainRoad(), *side.joins - away, *side.joins + away, true,
              fmt::format("light {}", side.number));
    // The light for vehicles that leave the side road is at the right of the side road.
    placer.tryPut(light, besideRoad(side, stopLineOfSideRoad(l), side.section.half + side.section.curb + 0.45),
                  fmt::format("light {}, out of the side road", side.number));
  }
}

// Tries to place an object at a random position along a plot, `depth` m from its front. Returns true if it is placed.
// Attempts on level ground increment `attempts`.
bool tryPutInPlot(Placer& placer, const Plot& plot, Draw& draw, Clutter clutter, double depth, int& attempts) {
  const Layout& l = placer.layout;
  Spot spot = l.inPlot(plot, draw.in(plot.from + 2, std::max(plot.from + 2.1, plot.to - 2)), depth);
  spot.yaw += (plot.side > 0 ? 0 : kPi) + draw.in(-0.4, 0.4);
  const Beside b = l.besideAt(spot.at);
  if (b.nearRoad && b.edge < (clutter == Clutter::Pond ? b.section.paved() : b.section.outer()) + 1) return false;
  if (!isLevel(l, spot.at)) return false;
  return placer.tryPut(anyClutter(placer, clutter, draw), spot, fmt::format("clutter {}", ++attempts));
}

// Places objects in front gardens, behind houses and on plots without a house.
void placeGardenThings(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.character.motorway) return;
  int attempts = 0;  // number of attempts on level ground so far; becomes the number in names
  int waters = 0;    // number of ponds and fountains
  const auto tryPut = [&](const Plot& plot, Draw& draw, Clutter clutter, double depth) {
    const bool placed = tryPutInPlot(placer, plot, draw, clutter, depth, attempts);
    waters += placed && (clutter == Clutter::Pond || clutter == Clutter::Fountain) ? 1 : 0;
  };
  for (const Plot& plot : l.plots) {
    Draw draw(l.seed, Kind::GardenThings, plot.number);
    if (plot.built) {
      const double rear = plot.setback + plot.depth;
      if (draw.chance(0.35)) tryPut(plot, draw, Clutter::Shed, rear + draw.in(3, 9));
      if (draw.chance(0.25)) tryPut(plot, draw, draw.chance(0.5) ? Clutter::Swing : Clutter::WoodPile, rear + 4);
      if (plot.setback < 4) continue;
      if (draw.chance(0.1)) tryPut(plot, draw, Clutter::Pond, draw.in(2, plot.setback - 1));
      if (draw.chance(0.12)) {
        const Clutter clutter = draw.chance(0.4)   ? Clutter::Heap
                                : draw.chance(0.5) ? Clutter::WoodPile
                                                   : Clutter::Pallets;
        tryPut(plot, draw, clutter, draw.in(2, plot.setback - 1));
      }
    } else if (draw.chance(0.4)) {
      const bool fountain = !l.character.country && !plot.bare && draw.chance(0.5);
      tryPut(plot, draw, fountain ? Clutter::Fountain : Clutter::Pond, draw.in(3.5, 8));
    }
  }
  // If there is no pond or fountain so far, tries to add a pond at the main road, so that most towns have water.
  Draw draw(l.seed, Kind::TownPond);
  for (int attempt = 0; attempt < 4 * Placer::kTries && waters == 0 && !l.plots.empty(); ++attempt) {
    const Plot& plot = draw.itemOf(l.plots);
    if (plot.road == 0) tryPut(plot, draw, Clutter::Pond, draw.in(2.2, 6));
  }
}

// Places benches and planters around the middle of each square, and a fountain in the middle of about half the squares.
void placeSquares(Placer& placer) {
  const Layout& l = placer.layout;
  const auto isSquare = [](const MapArea& area) { return area.land == Land::Paved && area.square; };
  if (std::ranges::none_of(l.areas.list(), isSquare)) return;
  const Model bench = models::makeFurnishing(placer.builder, l.seed, models::Furnishing::Bench);
  const Model planter = models::makeFurnishing(placer.builder, l.seed, models::Furnishing::Planter);
  std::uint32_t areaNumber = 0;
  for (const MapArea& area : l.areas.list()) {
    Draw draw(l.seed, Kind::Square, ++areaNumber);
    if (!isSquare(area)) continue;
    const Footprint about = rectangleAbout(area.outline);
    const auto tryPut = [&](const Model& m, const Point2& p, double yaw) {
      constexpr double kFromEdge = 1.5;  // m
      if (l.areas.outsideHard(p) > -kFromEdge || l.areas.landAt(p) != Land::Paved) return;
      placer.tryNumbered("square's",
                         [&](const std::string& name) { return placer.tryPut(m, {.at = p, .yaw = yaw}, name); });
    };
    if (draw.chance(0.5)) tryPut(anyClutter(placer, Clutter::Fountain, draw), about.center, 0);
    const int count = 3 + draw.below(8);
    for (int k = 0; k < count; ++k) {
      const Model& furnishing = draw.chance(0.6) ? bench : planter;
      const double angle = 2 * kPi * k / count;
      const double share = draw.in(0.4, 0.8);  // position between the square's middle (0) and its edge (1)
      const Point2 p = about.at(share * about.halfX * std::cos(angle), share * about.halfY * std::sin(angle));
      tryPut(furnishing, p, about.yaw + angle + kPi / 2);
    }
  }
}

}  // namespace

void placeClutter(Placer& placer) {
  const Model light = models::makeTrafficLight(placer.builder, placer.layout.seed);
  placeRoadworks(placer, light);
  if (!placer.layout.character.country) {
    placeCrossing(placer, light);
    placeSignals(placer, light);
  }
  placeGardenThings(placer);
  placeSquares(placer);
}

// Places dogs and cats within 3 m of the main road's curb and, on farmland, herds within 28 m of the curb.
void placeAnimals(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.parameters.people <= 0 || l.character.motorway) return;
  Draw draw(l.seed, Kind::Animals);
  const Road& road = l.mainRoad();
  const auto tryPut = [&](const Model& m, double along, double lateral) {
    Spot spot = besideRoad(road, along, lateral);
    spot.yaw = draw.in(0, 2 * kPi);
    const Beside b = l.besideAt(spot.at);
    if (b.nearRoad && b.edge < 0.2) return false;
    return placer.tryNumbered("animal", [&](const std::string& name) { return placer.tryPut(m, spot, name); });
  };
  const double curb = road.section.half + road.section.curb;  // m from the road's line to the curb's outer edge
  const int pets = 1 + draw.below(1 + static_cast<int>(0.4 * l.character.people * l.parameters.length / 100));
  for (int k = 0; k < pets; ++k) {
    const Model pet = models::makeAnimal(placer.builder, l.seed, draw.below(models::kPetForms), k % 6);
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      const int side = draw.chance(0.5) ? 1 : -1;
      const double lateral = side * (curb + draw.in(0.3, 3));
      if (tryPut(pet, draw.in(l.mainFrom + 20, l.mainTo - 20), lateral)) break;
    }
  }
  if (!l.character.farmland) return;
  const int herds = 1 + draw.below(3);
  for (int herd = 0; herd < herds; ++herd) {
    const int form = models::kPetForms + draw.below(models::kAnimalForms - models::kPetForms);
    const auto animals = placer.forms(3, [&](SceneBuilder& builder, std::uint64_t seed, int f) {
      return models::makeAnimal(builder, seed, form, 10 * herd + f);
    });
    const double middle = draw.in(l.mainFrom + 30, l.mainTo - 30);  // m along the road
    const int side = draw.chance(0.5) ? 1 : -1;
    const double lateral = side * (curb + draw.in(7, 22));
    const int count = 3 + draw.below(8);
    for (int k = 0; k < count; ++k) {
      const Model& animal = draw.itemOf(animals);
      const double along = middle + draw.in(-12, 12);
      tryPut(animal, along, lateral + draw.in(-6, 6));
    }
  }
}

}  // namespace scanmill::town
