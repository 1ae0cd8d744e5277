// Places everyday objects: roadworks, crossings with lights, objects in gardens and on squares, animals.

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

// Returns a random one of a few models of a kind of clutter.
const Model& anyClutter(Placer& placer, Clutter what, Draw& draw) {
  constexpr int kForms = 3;
  const int form = draw.below(kForms);
  return placer.model(Kind::Clutter, static_cast<int>(what) * kForms + form,
                      [&] { return models::makeClutter(placer.builder, placer.layout.seed, what, form); });
}

// Returns a random distance along the main road (m) such that no other road joins in the following `length` metres;
// nullopt if no attempt finds such a place.
std::optional<double> freeStretch(const Layout& l, Draw& draw, double length) {
  const Road& road = l.mainRoad();
  for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
    const double at = draw.in(l.mainFrom + 25, l.mainTo - 25 - length);
    bool clear = true;
    for (const double along : models::steps(at, at + length + 2, 2)) {
      const Point2 p = road.point(along);
      clear = clear && l.besideAt(p).edge > -road.section.half - 0.2;
    }
    if (clear) return at;
  }
  return std::nullopt;
}

// Places two lights beside a road: at `first` for vehicles that drive in the direction of the road's line, at `last`
// for vehicles that drive against it (m along the road). `marked`: the lights have stop lines.
void putLights(Placer& placer, const Model& light, const Road& road, double first, double last, bool marked,
               const std::string& name) {
  const double out = road.section.half + road.section.curb + 0.45;
  Spot with = besideRoad(road, first, -out);
  with.yaw += kPi;
  placer.tryPut(light, with, name + ", with the line");
  placer.tryPut(light, besideRoad(road, last, out), name + ", against the line");
  Draw draw(placer.layout.seed, Kind::LightPhase, placer.lights.size());
  placer.lights.push_back({last + 1, first - 1, draw.in(0, Placer::Light::kPeriod), marked});
}

// True if heights around the point differ by less than 0.35 m, so that a wide, flat object can be placed there.
bool isLevel(const Layout& l, const Point2& p) {
  double low = 1e9;
  double high = -1e9;
  for (const double dx : {-1.2, 1.2}) {
    for (const double dy : {-1.2, 1.2}) {
      const double z = l.heightAt({p.x + dx, p.y + dy});
      low = std::min(low, z);
      high = std::max(high, z);
    }
  }
  return high - low < 0.35;
}

// Places roadworks in the lane that the ego vehicle does not use.
void placeRoadworks(Placer& placer, const Model& light) {
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Roadworks);
  const bool rural = l.character.country;
  // A one-way road has only the lane that the ego vehicle uses.
  if (l.mainRoad().oneWay() || l.character.motorway) return;
  if (!draw.chance(rural ? 0.5 : 0.3)) return;
  const double length = draw.in(9, 18);
  const std::optional<double> at = freeStretch(l, draw, length);
  if (!at) return;
  const Road& road = l.mainRoad();
  const double edge = road.section.half - road.section.parking;
  const auto put = [&](const Model& m, double along, double lateral, double turn, const std::string& name) {
    Spot spot = besideRoad(road, *at + along, lateral);
    spot.yaw += turn;
    placer.tryPark(m, spot, name);
  };
  if (l.parameters.vehicles > 0) {
    const Model excavator = models::makeWorkVehicle(placer.builder, l.seed, models::WorkVehicle::Excavator, 0);
    put(excavator, 0.4 * length, std::max(edge - 1.3, 1.6), draw.chance(0.5) ? 0 : kPi, "excavator");
  }
  put(anyClutter(placer, Clutter::Heap, draw), 0.8 * length, std::max(edge - 1.1, 2.0), 0, "heap");
  put(anyClutter(placer, draw.chance(0.5) ? Clutter::Pallets : Clutter::Skip, draw), 1.5, edge - 1.1, 0,
      "roadworks' goods");
  const Model& barrier = anyClutter(placer, Clutter::Barrier, draw);
  const double across = std::max(edge - 1.2, 1.4);
  put(barrier, -0.6, across, kPi / 2, "barrier 1");
  put(barrier, length + 0.6, across, kPi / 2, "barrier 2");
  int number = 0;
  for (const double along : models::steps(0, length, draw.in(2, 3))) {
    const Model& cone = anyClutter(placer, Clutter::Cone, draw);
    const double lateral = std::max(edge - 2.6, 0.45) + draw.in(-0.1, 0.1);
    put(cone, along, lateral, draw.in(0, 1), fmt::format("cone {}", ++number));
  }
  if (rural || draw.chance(0.4)) putLights(placer, light, road, *at - 6, *at + length + 6, false, "roadworks' light");
}

// Places a pedestrian crossing on the main road: stripes and lights.
void placeCrossing(Placer& placer, const Model& light) {
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Crossing);
  constexpr double kLength = 3;
  const std::optional<double> at = freeStretch(l, draw, kLength);
  if (!at) return;
  const Road& road = l.mainRoad();
  // Vehicles park neither on the crossing nor close to it.
  const Spot middle = besideRoad(road, *at + kLength / 2, 0);
  const Footprint place{middle.at, kLength / 2 + 4, road.section.half, middle.yaw};
  if (!placer.isFree(place)) return;
  placer.noParking.add(place);
  Shape s(placer.builder, "crossing");
  const models::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  const double half = road.section.half - 0.3;
  for (const double lateral : models::steps(-half, half - 0.5, 1)) {
    constexpr int kPieces = 3;
    for (int piece = 0; piece < kPieces; ++piece) {
      const auto along = [&](int k) { return *at + kLength * k / kPieces; };
      paintBar(s, paint, l, road, along(piece), along(piece + 1), lateral, lateral + 0.5);
    }
  }
  placer.builder.place(s.finish().mesh, placer.worldFromTown, "crossing");
  putLights(placer, light, road, *at - 1, *at + kLength + 1, true, "crossing's light");
}

// Places traffic lights at some of the junctions of a side road with the main road.
void placeSignals(Placer& placer, const Model& light) {
  const Layout& l = placer.layout;
  for (const Road& side : l.roads()) {
    Draw draw(l.seed, Kind::Signals, side.number);
    if (!draw.chance(l.character.lights) || !side.joins) continue;
    const double away = side.section.half + 5;
    putLights(placer, light, l.mainRoad(), *side.joins - away, *side.joins + away, true,
              fmt::format("light {}", side.number));
    // The light of the side road, at its right as seen by those who come out.
    placer.tryPut(light, besideRoad(side, stopLineOfSideRoad(l), side.section.half + side.section.curb + 0.45),
                  fmt::format("light {}, out of the side road", side.number));
  }
}

// Places objects in front gardens, behind houses and on plots without a house.
void placeGardenThings(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.character.motorway) return;
  int number = 0;
  int water = 0;
  const auto tryAt = [&](const Plot& plot, Draw& draw, Clutter what, double depth) {
    Spot spot = l.inPlot(plot, draw.in(plot.from + 2, std::max(plot.from + 2.1, plot.to - 2)), depth);
    spot.yaw += (plot.side > 0 ? 0 : kPi) + draw.in(-0.4, 0.4);
    const Beside b = l.besideAt(spot.at);
    if (b.nearRoad && b.edge < (what == Clutter::Pond ? b.section.paved() : b.section.outer()) + 1) return false;
    if (!isLevel(l, spot.at)) return false;
    return placer.tryPut(anyClutter(placer, what, draw), spot, fmt::format("clutter {}", ++number));
  };
  for (const Plot& plot : l.plots) {
    Draw draw(l.seed, Kind::GardenThings, plot.number);
    if (plot.built) {
      const double behind = plot.setback + plot.depth;
      if (draw.chance(0.35)) tryAt(plot, draw, Clutter::Shed, behind + draw.in(3, 9));
      if (draw.chance(0.25)) tryAt(plot, draw, draw.chance(0.5) ? Clutter::Swing : Clutter::WoodPile, behind + 4);
      if (plot.setback < 4) continue;
      if (draw.chance(0.1)) water += tryAt(plot, draw, Clutter::Pond, draw.in(2, plot.setback - 1)) ? 1 : 0;
      if (draw.chance(0.12)) {
        const Clutter what = draw.chance(0.4) ? Clutter::Heap : draw.chance(0.5) ? Clutter::WoodPile : Clutter::Pallets;
        tryAt(plot, draw, what, draw.in(2, plot.setback - 1));
      }
      continue;
    }
    if (!draw.chance(0.4)) continue;
    const bool square = !l.character.country && !plot.bare && draw.chance(0.5);
    water += tryAt(plot, draw, square ? Clutter::Fountain : Clutter::Pond, draw.in(3.5, 8)) ? 1 : 0;
  }
  // If no water has been placed, tries to add a pond at the main road, so that few towns have no water.
  Draw draw(l.seed, Kind::TownPond);
  for (int attempt = 0; attempt < 4 * Placer::kTries && water == 0 && !l.plots.empty(); ++attempt) {
    const Plot& plot = draw.itemOf(l.plots);
    if (plot.road == 0) water += tryAt(plot, draw, Clutter::Pond, draw.in(2.2, 6)) ? 1 : 0;
  }
}

// Places a fountain in the middle of about half of the squares, and benches and planters around the middle of each.
void placeSquares(Placer& placer) {
  const Layout& l = placer.layout;
  std::uint32_t square = 0;
  int number = 0;
  const bool any = std::any_of(l.areas.list().begin(), l.areas.list().end(),
                               [](const MapArea& area) { return area.land == Land::Paved && area.square; });
  if (!any) return;
  const Model bench = models::makeFurnishing(placer.builder, l.seed, models::Furnishing::Bench);
  const Model planter = models::makeFurnishing(placer.builder, l.seed, models::Furnishing::Planter);
  for (const MapArea& area : l.areas.list()) {
    Draw draw(l.seed, Kind::Square, ++square);
    if (area.land != Land::Paved || !area.square) continue;
    const Footprint about = rectangleAbout(area.outline);
    const auto put = [&](const Model& m, const Point2& p, double yaw) {
      if (l.areas.outsideHard(p) > -1.5 || l.areas.landAt(p) != Land::Paved) return;
      if (placer.tryPut(m, {p, yaw, 1, 0}, fmt::format("square's {}", number + 1))) ++number;
    };
    if (draw.chance(0.5)) put(anyClutter(placer, Clutter::Fountain, draw), about.center, 0);
    const int count = 3 + draw.below(8);
    for (int k = 0; k < count; ++k) {
      const Model& what = draw.chance(0.6) ? bench : planter;
      const double angle = 2 * kPi * k / count;
      const double away = draw.in(0.4, 0.8);
      const Point2 p = about.at(away * about.halfX * std::cos(angle), away * about.halfY * std::sin(angle));
      put(what, p, about.yaw + angle + kPi / 2);
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

// Places dogs and cats within 3 m of the main road's curb; in rural towns also herds within 28 m of this curb.
void placeAnimals(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.parameters.people <= 0 || l.character.motorway) return;
  Draw draw(l.seed, Kind::Animals);
  const Road& road = l.mainRoad();
  int number = 0;
  const auto put = [&](const Model& m, double along, double lateral) {
    Spot spot = besideRoad(road, along, lateral);
    spot.yaw = draw.in(0, 2 * kPi);
    const Beside b = l.besideAt(spot.at);
    if (b.nearRoad && b.edge < 0.2) return false;
    if (!placer.tryPut(m, spot, fmt::format("animal {}", number + 1))) return false;
    ++number;
    return true;
  };
  const double curb = road.section.half + road.section.curb;
  const int pets = 1 + draw.below(1 + static_cast<int>(0.4 * l.character.people * l.parameters.length / 100));
  for (int k = 0; k < pets; ++k) {
    const Model pet = models::makeAnimal(placer.builder, l.seed, draw.below(models::kPetForms), k % 6);
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      const int side = draw.chance(0.5) ? 1 : -1;
      const double lateral = side * (curb + draw.in(0.3, 3));
      if (put(pet, draw.in(l.mainFrom + 20, l.mainTo - 20), lateral)) break;
    }
  }
  if (!l.character.farmland) return;
  const int herds = 1 + draw.below(3);
  for (int herd = 0; herd < herds; ++herd) {
    const int form = models::kPetForms + draw.below(models::kAnimalForms - models::kPetForms);
    const auto forms =
        models::makeForms(3, [&](int f) { return models::makeAnimal(placer.builder, l.seed, form, 10 * herd + f); });
    const double at = draw.in(l.mainFrom + 30, l.mainTo - 30);
    const int side = draw.chance(0.5) ? 1 : -1;
    const double lateral = side * (curb + draw.in(7, 22));
    const int count = 3 + draw.below(8);
    for (int k = 0; k < count; ++k) {
      const Model& animal = draw.itemOf(forms);
      const double along = at + draw.in(-12, 12);
      put(animal, along, lateral + draw.in(-6, 6));
    }
  }
}

}  // namespace scanmill::town
