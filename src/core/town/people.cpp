// Places pedestrians, and parked bicycles and motorcycles beside roads.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "base/path.h"
#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;

// A position on a pavement, or beside a road that has no pavement.
struct Place {
  const Road* road = nullptr;
  double along = 0;    // m along the road's line
  double lateral = 0;  // m to the left of the line
  double sense = 1;    // direction of walking: 1 along the line, -1 against it

  Spot spot() const {
    Spot s = besideRoad(*road, along, lateral);
    s.yaw += sense < 0 ? kPi : 0;
    return s;
  }
};

std::optional<Place> besidePeople(const Placer& placer, Draw& draw) {
  const Layout& l = placer.layout;
  const auto r = static_cast<std::size_t>(draw.chance(0.7) ? 0 : draw.below(static_cast<int>(l.roads().size())));
  const Road& road = l.roads()[r];
  const CrossSection& s = road.section;
  const double at = road.main ? draw.in(l.mainFrom, l.mainTo) : draw.in(10, road.length());
  const double out =
      s.sidewalk > 0 ? s.curb + s.verge + draw.in(0.3, std::max(0.4, s.sidewalk - 0.3)) : draw.in(0.4, 1);
  const double side = draw.sign();
  const Place place{&road, at, side * (s.half + out), draw.sign()};
  const Spot spot = place.spot();
  if (l.besideAt(spot.at).edge <= 0.2) return std::nullopt;
  return place;
}

// True at the ends of the main road, where traffic comes out of the ground and goes back into it.
bool isAtEnd(const Layout& l, const Point2& p) {
  constexpr double kNear = 20;  // m
  const std::vector<Point2>& line = l.mainRoad().line;
  return std::min(distance(p, line.front()), distance(p, line.back())) < kNear;
}

// Returns how far (m) a pedestrian or cyclist can go from a place before an object, another road or the end of the road
// is in the way; at most `most`. `half`: half of the width that must be free (m), of which 0.2 m may be over a road.
double freeWay(const Placer& placer, Place place, double most, double half) {
  const double start = place.along;
  for (const double done : models::steps(0, most, 0.5)) {
    place.along = start + place.sense * done;
    if (place.along < 4 || place.along > place.road->length() - 4) return done;
    const Spot spot = place.spot();
    if (isAtEnd(placer.layout, spot.at)) return done;
    const double edge = placer.layout.besideAt(spot.at).edge;
    if (edge < half - 0.2 || edge > 12 || !placer.occupancy.isFree({spot.at, half, half, spot.yaw})) return done;
  }
  return most;
}

// Places a pedestrian who walks along a road. Returns false if the free way is too short.
bool placeWalker(Placer& placer, Draw& draw, const models::Walker& walker, const std::string& name) {
  constexpr double kLeast = 12;  // m, least length of the free way
  constexpr double kMost = 110;
  constexpr double kPiece = 3;
  constexpr double kLeastDuration = 120;  // s, time that the path must last
  const std::optional<Place> place = besidePeople(placer, draw);
  const double speed = draw.in(1.0, 1.6);
  if (!place) return false;
  const double way = freeWay(placer, *place, kMost, 0.4);
  if (way < kLeast) return false;
  // The path leads to the end of the way, turns in its last 0.25 m and leads back, as often as the duration needs.
  // Lateral distance (m) of the path from the middle of the free way: to one side on the way there, to the other side
  // on the way back.
  constexpr double kAside = 0.15;
  const auto pieces = static_cast<int>(way / kPiece);
  const auto at = [&](double done, double left) {
    Place here = *place;
    here.along += here.sense * way * done / pieces;
    here.lateral += here.sense * left;
    return here.spot();
  };
  std::vector<Vec3d> points;
  const auto walk = [&](double done, double left) {
    points.push_back(placer.worldFromTown * placer.layout.onGround(at(done, left).at));
  };
  for (int k = 0; k < pieces; ++k) {
    const Spot middle = at(k + 0.5, 0);
    placer.occupancy.add({middle.at, way / pieces / 2, 0.4, middle.yaw});
  }
  // The turn begins 0.25 m before an end. `round` is this distance as a number of pieces.
  const double round = 0.25 * pieces / way;
  const auto laps = static_cast<int>(std::ceil(speed * kLeastDuration / (2 * way)));
  for (int lap = 0; lap < laps; ++lap) {
    for (int k = 0; k < pieces; ++k) walk(k + round, -kAside);
    walk(pieces - round, -kAside);
    walk(pieces, 0);
    for (int k = pieces; k > 0; --k) walk(k - round, kAside);
    walk(round, kAside);
    walk(0, 0);
  }
  const auto path = std::make_shared<const Path>(points);
  const auto animation = std::make_shared<Animation>();
  for (const Model& m : walker.moments) animation->meshes.push_back(m.mesh);
  animation->period = walker.stride / speed;
  animation->until = path->length() / speed;
  placer.putMoving(walker.moments.front().mesh, name, std::make_shared<const Movement>(path, 0, speed), animation);
  return true;
}

// Places a cyclist who rides along a pavement and stops where the free way ends. Returns false if this way is too
// short.
bool placeCyclist(Placer& placer, Draw& draw, const Model& bicycle, const Model& rider, const std::string& name) {
  constexpr double kLeast = 20;  // m, least length of the free way
  constexpr double kMost = 110;
  constexpr double kPiece = 3;
  const std::optional<Place> place = besidePeople(placer, draw);
  const double speed = draw.in(2, 4);
  if (!place) return false;
  const double way = freeWay(placer, *place, kMost, 0.7);
  if (way < kLeast) return false;
  std::vector<Vec3d> points;
  Place here = *place;
  for (const double done : models::steps(1.5, way - 1.5, kPiece)) {
    here.along = place->along + place->sense * done;
    const Spot spot = here.spot();
    placer.occupancy.add({spot.at, kPiece / 2 + 0.9, 0.5, spot.yaw});
    points.push_back(placer.worldFromTown * placer.layout.onGround(spot.at));
  }
  const auto path = std::make_shared<const Path>(points);
  const auto movement = std::make_shared<const Movement>(path, draw.in(0, 0.7) * path->length(), speed);
  placer.putMoving(bicycle.mesh, name, movement);
  placer.putMoving(rider.mesh, "rider of " + name, movement);
  return true;
}

}  // namespace

void placePeople(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.character.district == District::Motorway) return;
  const double length = l.mainTo - l.mainFrom;
  Draw counts(l.seed, Kind::PeopleCounts);
  // Returns the number of people or vehicles of a kind: at least one, unless people are switched off.
  const auto count = [&](double share) {
    const int drawn = static_cast<int>(share * l.character.people * length / 100 + counts.next());
    return l.parameters.people > 0 ? std::max(1, drawn) : 0;
  };
  const int walkers = count(1);
  const int parked = count(0.6);
  const int motorcycles = count(0.6);
  const int cyclists = count(2);
  const auto search = [&](const Model& m, Draw& draw, const std::string& name, double lean) {
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      const std::optional<Place> place = besidePeople(placer, draw);
      if (!place) continue;
      Spot spot = place->spot();
      spot.yaw += draw.in(-0.3, 0.3);
      spot.lean = lean;
      if (placer.tryPut(m, spot, name)) return;
    }
  };
  // Places up to `most` vehicles side by side, across the pavement or, where it is narrow, along it.
  const auto row = [&](const std::vector<Model>& forms, Draw& draw, const std::string& name, double lean, int most) {
    constexpr double kApart = 0.75;  // m between neighbours
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      std::optional<Place> place = besidePeople(placer, draw);
      if (!place) continue;
      const CrossSection& s = place->road->section;
      const bool across = s.sidewalk > 2.6;
      // Near the walls, where there is room for those who walk.
      if (across) place->lateral = std::copysign(place->road->section.half + s.outer() - 1.1, place->lateral);
      const int wanted = 1 + draw.below(most);
      int found = 0;
      for (int k = 0; k < wanted; ++k) {
        Spot spot = place->spot();
        const bool onRoad = l.besideAt(spot.at).edge < 0.3;
        if (onRoad || place->along > place->road->length() - 3) break;
        spot.yaw += (across ? kPi / 2 : 0) + draw.in(-0.08, 0.08);
        spot.lean = lean;
        if (!placer.tryPut(draw.of(forms), spot, fmt::format("{}.{}", name, k + 1))) break;
        ++found;
        place->along += across ? kApart : 2.2;
      }
      if (found > 0) return;
    }
  };
  // Two of three pedestrians walk.
  constexpr int kWalkers = 5;
  constexpr int kStanding = 4;
  const auto walking = models::makeForms(std::min(walkers, kWalkers),
                                         [&](int f) { return models::makeWalker(placer.builder, l.seed, f); });
  const auto standing = models::makeForms(std::min((walkers + 2) / 3, kStanding),
                                          [&](int f) { return models::makePedestrian(placer.builder, l.seed, f); });
  for (int i = 0; i < walkers; ++i) {
    Draw draw(l.seed, Kind::Pedestrian, static_cast<std::uint32_t>(i));
    const std::string name = fmt::format("pedestrian {}", i + 1);
    if (i % 3 == 2) {
      search(standing[static_cast<std::size_t>(i / 3) % standing.size()], draw, name, 0);
      continue;
    }
    const models::Walker& walker = walking[static_cast<std::size_t>(i) % walking.size()];
    bool walks = false;
    for (int attempt = 0; attempt < Placer::kTries && !walks; ++attempt) {
      walks = placeWalker(placer, draw, walker, name);
    }
    if (!walks) search(standing[static_cast<std::size_t>(i) % standing.size()], draw, name, 0);
  }
  const auto bicycles =
      models::makeForms(std::min(parked, 4), [&](int f) { return models::makeBicycle(placer.builder, l.seed, f); });
  for (int i = 0; i < parked; ++i) {
    Draw draw(l.seed, Kind::ParkedBicycles, static_cast<std::uint32_t>(i));
    row(bicycles, draw, fmt::format("bicycle {}", i + 1), radians(draw.in(-9, -5)), 8);
  }
  constexpr int kCyclists = 3;
  const auto riding = models::makeForms(std::min(cyclists, kCyclists), [&](int f) {
    return models::makeCyclist(placer.builder, l.seed, kRoadCyclistForms + f);
  });
  for (int i = 0; i < cyclists; ++i) {
    Draw draw(l.seed, Kind::SidewalkCyclist, static_cast<std::uint32_t>(i));
    const auto& [bicycle, rider] = riding[static_cast<std::size_t>(i) % riding.size()];
    bool rides = false;
    for (int attempt = 0; attempt < Placer::kTries && !rides; ++attempt) {
      rides = placeCyclist(placer, draw, bicycle, rider, fmt::format("cyclist's bicycle on the sidewalk {}", i + 1));
    }
  }
  const auto motorcycleForms = models::makeForms(
      std::min(motorcycles, 2), [&](int f) { return models::makeMotorcycle(placer.builder, l.seed, f); });
  for (int i = 0; i < motorcycles; ++i) {
    Draw draw(l.seed, Kind::ParkedMotorcycles, static_cast<std::uint32_t>(i));
    row(motorcycleForms, draw, fmt::format("motorcycle {}", i + 1), radians(8), 4);
  }
}

}  // namespace scanmill::town
