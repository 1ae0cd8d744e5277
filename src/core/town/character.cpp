#include "town/character.h"

#include <fmt/format.h>

#include <algorithm>

namespace scanmill::town {
namespace {

using models::Kind;

District districtOf(const Parameters& p, Draw& draw) {
  const double pick = draw.next();
  if (p.district == "rural") return District::Rural;
  if (p.district == "suburban") return District::Suburban;
  if (p.district == "dense") return District::Dense;
  return pick < 0.25 ? District::Rural : pick < 0.7 ? District::Suburban : District::Dense;
}

}  // namespace

Parameters readParameters(Fields& fields) {
  Parameters p;
  p.district = fields.choice("district", {"any", "rural", "suburban", "dense"}, p.district);
  p.season = fields.choice("season", {"any", "summer", "autumn", "winter"}, p.season);
  if (const auto map = fields.optionalPath("map")) p.map = *map;
  p.road = fields.text("road", "");
  p.keepsLeft = fields.choice("driving_side", {"right", "left"}, "right") == "left";
  if (!p.road.empty() && p.map.empty()) {
    throw InputError(fields.find("road")->where, "road is the name of a map's main road: give the key `map` too");
  }
  p.length = fields.number("length", {100, 1000}, p.length);
  const Range factor{0, 5};
  p.slope = fields.number("slope", {0, 3}, p.slope);
  p.greenery = fields.number("greenery", factor, p.greenery);
  p.vehicles = fields.number("vehicles", factor, p.vehicles);
  p.traffic = fields.number("traffic", factor, p.traffic);
  p.people = fields.number("people", factor, p.people);
  p.detail = fields.number("detail", {0.05, 2}, p.detail);
  return p;
}

Character::Character(const Parameters& p, std::uint64_t seed) {
  Draw draw(seed, Kind::Town);
  district = districtOf(p, draw);
  const bool rural = district == District::Rural;
  const bool dense = district == District::Dense;
  const double lane = rural ? draw.in(2.4, 3.2) : draw.in(2.7, 3.6);
  main.parking = rural ? 0 : draw.chance(dense ? 0.65 : 0.3) ? draw.in(1.9, 2.4) : 0;
  main.half = lane + main.parking;
  main.sidewalk = rural ? (draw.chance(0.3) ? draw.in(1.2, 1.8) : 0) : dense ? draw.in(1.8, 4.5) : draw.in(1.2, 2.6);
  main.curb = main.sidewalk > 0 ? 0.15 : 0;
  main.step = main.sidewalk > 0 ? draw.in(0.08, 0.16) : 0;
  main.verge = rural ? draw.in(0.8, 2.5) : draw.chance(dense ? 0.25 : 0.55) ? draw.in(0.8, 4.5) : 0;
  side = main;
  side.parking = rural ? 0 : draw.chance(0.3) ? draw.in(1.9, 2.3) : 0;
  side.half = draw.in(2.2, 3.2) + side.parking;
  side.verge *= draw.in(0, 1);
  side.sidewalk *= draw.in(0.7, 1.0);
  sideRoads = rural ? draw.below(3) : 2 + draw.below(4);
  bend = dense ? draw.in(0, 0.35) : draw.in(0.15, 0.9);
  hills = p.slope * draw.in(1.5, dense ? 4.5 : 7);
  banks = p.slope * (dense ? draw.in(0.5, 2.5) : draw.in(2, 7));
  undulation = rural ? draw.in(0.3, 0.7) : dense ? draw.in(0.1, 0.25) : draw.in(0.15, 0.45);
  setback = rural ? draw.in(4, 20) : dense ? draw.in(0, 1.2) : draw.in(1, 9);
  setbackSpread = dense ? draw.in(0, 0.6) : setback * draw.in(0.1, 0.6);
  built = rural ? draw.in(0.15, 0.5) : dense ? draw.in(0.85, 1) : draw.in(0.6, 0.95);
  plotWidth = rural ? draw.in(22, 40) : dense ? draw.in(10, 15) : draw.in(13, 24);
  floorsLow = dense ? 2 + draw.below(2) : 1;
  floorsHigh = dense ? floorsLow + 1 + draw.below(2) : 2;
  const double green = p.greenery * draw.in(0.5, 1.6);
  hedges = std::min(0.9, green * (dense ? 0.05 : draw.in(0.2, 0.7)));
  fences = (1 - hedges) * draw.in(0.2, 0.6);
  avenue = std::min(1.0, green * draw.in(0, dense ? 0.6 : 0.8));
  gardenTrees = green * (dense ? 0.3 : draw.in(0.6, 2.2));
  gardenBushes = green * (dense ? 0.8 : draw.in(2, 7));
  woods = std::min(0.95, green * (rural ? draw.in(0.3, 0.8) : dense ? draw.in(0.05, 0.3) : draw.in(0.15, 0.6)));
  // Many towns have almost no parked vehicles; a few towns are full of them.
  const double full = draw.next();
  parked = std::min(0.95, p.vehicles * full * full * full * (rural ? 0.1 : dense ? 0.8 : 0.5));
  traffic = p.vehicles * p.traffic * draw.in(0.1, rural ? 0.8 : 2.2);
  people = p.people * (rural ? draw.in(0, 1.5) : dense ? draw.in(3, 12) : draw.in(0.5, 4));
  clutter = rural ? draw.in(1, 4) : dense ? draw.in(6, 16) : draw.in(3, 9);
  // The season has its own random stream, so that everything else is the same in all seasons.
  Draw sky(seed, Kind::Town, 1);
  const double pick = sky.next();
  season = p.season == "any"      ? (pick < 0.5    ? Season::Summer
                                     : pick < 0.75 ? Season::Autumn
                                                   : Season::Winter)
           : p.season == "autumn" ? Season::Autumn
           : p.season == "winter" ? Season::Winter
                                  : Season::Summer;
  wear = sky.next() * sky.next();
  if (season == Season::Autumn) foliage = sky.in(0.15, 0.7);
  if (season == Season::Winter) {
    foliage = 0.03;
    snow = sky.in(0.04, 0.25);
    snowBanks = sky.in(0.2, 0.7);
  }
}

std::string Character::inWords() const {
  const char* const place = district == District::Rural ? "rural" : district == District::Dense ? "dense" : "suburban";
  const char* const time = season == Season::Summer ? "summer" : season == Season::Autumn ? "autumn" : "winter";
  return fmt::format("{}, {}", place, time);
}

}  // namespace scanmill::town
