#include "town/character.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace scanmill::town {
namespace {

using models::Kind;

// The ends of the interval from which a town draws a property.
struct Between {
  double low = 0, high = 0;

  double of(Draw& draw) const { return draw.in(low, high); }
  // Returns a random integer from `low` to `high`, both included.
  int integerOf(Draw& draw) const { return static_cast<int>(low) + draw.below(static_cast<int>(high - low) + 1); }
};

// The kinds of places. The seed selects one of them, but never Street.
enum class District { Rural, Suburban, Dense, Boulevard, OldTown, Arterial, Commercial, Motorway, Street };

constexpr std::array<DistrictTraits, 9> kDistricts{{
    {.name = "rural", .country = true, .farmland = true},
    {.name = "suburban"},
    {.name = "dense", .terraced = true},
    {.name = "boulevard", .terraced = true},
    {.name = "old_town", .terraced = true, .cobbled = true},
    {.name = "arterial"},
    {.name = "commercial", .commercial = true},
    {.name = "motorway", .country = true, .motorway = true},
    {.name = "street", .plain = true},
}};  // by District

using OfKinds = std::array<Between, kDistricts.size()>;  // by District

// Widths and speeds are those of the German guidelines for urban roads (RASt 06), rural roads (RAL) and motorways
// (RAA): lanes of 2.75 to 3.75 m, wider where there is no parking lane, pavements of at least 2.5 m, shoulders of 2.5
// m. All else are estimates. Values without a unit are the fractions, numbers and probabilities that Character
// describes.
// clang-format off
namespace property {
//                               rural        suburban     dense        boulevard    old_town     arterial     commercial   motorway     street
constexpr OfKinds kLanes      {{{1, 1},      {1, 1},      {1, 1},      {2, 2},      {1, 1},      {1, 2},      {1, 1},      {2, 3},      {1, 1}}};  // in each direction
constexpr OfKinds kLane       {{{2.8, 3.5},  {4, 5.4},    {3.4, 4.4},  {3, 3.4},    {2.2, 2.8},  {3.8, 4.8},  {4.2, 5.5},  {3.5, 3.75}, {3.5, 3.5}}};  // m, width
constexpr OfKinds kShoulder   {{{0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {2.5, 2.5},  {0, 0}}};  // m
constexpr OfKinds kMedian     {{{0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0.6, 1.5},  {0, 0}}};  // m, half of it
constexpr OfKinds kBays       {{{0, 0},      {0.15, 0.15},{0.5, 0.5},  {1, 1},      {0, 0},      {0.15, 0.15},{0.15, 0.15},{0, 0},      {1, 1}}};  // probability of parking lanes
constexpr OfKinds kWalks      {{{0.15, 0.15},{1, 1},      {1, 1},      {1, 1},      {1, 1},      {1, 1},      {1, 1},      {0, 0},      {1, 1}}};  // probability of sidewalks
constexpr OfKinds kSidewalk   {{{1.2, 1.8},  {1.8, 3},    {2.4, 4.5},  {4, 7},      {0.8, 1.8},  {2, 3.8},    {1.8, 3.2},  {0, 0},      {2.5, 2.5}}};  // m
constexpr OfKinds kGrassy     {{{1, 1},      {0.15, 0.15},{0, 0},      {0, 0},      {0, 0},      {0.35, 0.35},{0.2, 0.2},  {1, 1},      {0, 0}}};  // probability of a verge
constexpr OfKinds kVerge      {{{0.8, 2.5},  {0.8, 2.5},  {0, 0},      {0, 0},      {0, 0},      {1.5, 4},    {1, 3},      {2, 5},      {0, 0}}};  // m
constexpr OfKinds kApron      {{{0, 0},      {0, 0.8},    {14, 22},    {14, 22},    {12, 20},    {0, 0},      {0, 3},      {0, 0},      {0, 0}}};  // m
constexpr OfKinds kStep       {{{0.02, 0.1}, {0.02, 0.1}, {0.02, 0.1}, {0.02, 0.1}, {0.01, 0.05},{0.02, 0.1}, {0.02, 0.1}, {0.02, 0.1}, {0.12, 0.12}}};  // m
constexpr OfKinds kSideRoads  {{{1, 3},      {6, 9},      {3, 5},      {3, 5},      {3, 6},      {2, 4},      {3, 5},      {0, 0},      {1, 2}}};
constexpr OfKinds kBend       {{{0.15, 0.9}, {0.1, 0.6},  {0, 0.35},   {0, 0.2},    {0.2, 0.7},  {0.05, 0.4}, {0, 0.3},    {0.05, 0.3}, {0, 0}}};  // rad
constexpr OfKinds kHills      {{{1.5, 7},    {2.5, 8},    {1.5, 5},    {1, 4},      {1, 6},      {2, 7},      {1, 5},      {1, 5},      {0, 0}}};  // m
constexpr OfKinds kBanks      {{{2, 7},      {0.8, 4},    {0.3, 1.5},  {0.3, 1},    {0.3, 1.5},  {1, 4},      {0.5, 2},    {1, 5},      {0, 0}}};  // m
constexpr OfKinds kUndulation {{{0.3, 0.7},  {0.1, 0.35}, {0.1, 0.2},  {0.1, 0.2},  {0.1, 0.2},  {0.1, 0.35}, {0.1, 0.3},  {0.2, 0.6},  {0, 0}}};  // m
constexpr OfKinds kSetback    {{{4, 20},     {8, 18},     {0, 6},      {0, 4},      {0, 0.4},    {8, 18},     {14, 26},    {20, 30},    {3, 6}}};  // m
constexpr OfKinds kBuilt      {{{0.15, 0.5}, {0.25, 0.45},{0.85, 1},   {0.85, 1},   {0.85, 1},   {0.35, 0.65},{0.25, 0.5}, {0, 0},      {0.9, 0.9}}};
constexpr OfKinds kPlotWidth  {{{22, 40},    {15, 26},    {10, 15},    {12, 18},    {7, 12},     {18, 32},    {28, 45},    {30, 60},    {14, 20}}};  // m
constexpr OfKinds kFloors     {{{1, 2},      {1, 2},      {2, 4},      {3, 5},      {2, 3},      {1, 3},      {1, 3},      {1, 1},      {1, 2}}};
constexpr OfKinds kHedges     {{{0.1, 0.4},  {0.38, 0.58},{0.1, 0.25}, {0.1, 0.25}, {0, 0.05},   {0.3, 0.5},  {0.25, 0.4}, {0, 0},      {0.3, 0.3}}};
constexpr OfKinds kFences     {{{0.1, 0.3},  {0.2, 0.35}, {0.2, 0.4},  {0.1, 0.3},  {0, 0.2},    {0.25, 0.35},{0.25, 0.4}, {0, 0},      {0.3, 0.3}}};
constexpr OfKinds kAvenue     {{{0, 0.7},    {0, 0.3},    {0.2, 0.7},  {0.6, 0.95}, {0, 0.2},    {0.2, 0.8},  {0, 0.5},    {0, 0},      {0.5, 0.5}}};
constexpr OfKinds kTrees      {{{0.6, 2.2},  {1.5, 3.5},  {0, 0.4},    {0, 0.3},    {0, 0.4},    {1, 2.5},    {0.3, 1.2},  {0.5, 3},    {0.5, 1}}};
constexpr OfKinds kBushes     {{{2, 6},      {1, 5},      {0, 0.8},    {0, 0.4},    {0, 0.6},    {1, 5},      {1, 4},      {1, 6},      {2, 3}}};
constexpr OfKinds kWoods      {{{0.3, 0.8},  {0.4, 0.8},  {0.05, 0.3}, {0.05, 0.2}, {0.05, 0.3}, {0.5, 0.85}, {0.3, 0.7},  {0.3, 0.8},  {0, 0}}};
constexpr OfKinds kForecourts {{{0, 0},      {0.3, 0.65}, {0, 0},      {0, 0},      {0, 0},      {0.1, 0.4},  {0.5, 0.9},  {0, 0},      {0, 0}}};
constexpr OfKinds kParked     {{{0, 0.1},    {0.2, 0.6},  {0.15, 0.6}, {0.5, 1},    {0.1, 0.5},  {0.05, 0.4}, {0.2, 0.7},  {0, 0},      {0.3, 0.3}}};
constexpr OfKinds kTraffic    {{{0.8, 2},    {2, 4},      {2, 4},      {1, 2.5},    {0.2, 0.8},  {2, 4},      {2, 4},      {0.8, 2.5},  {3, 3}}};  // per 100 m and lane
constexpr OfKinds kSpeed      {{{15, 24},    {8.3, 13.9}, {8.3, 13.9}, {11, 13.9},  {5, 8.3},    {13.9, 16.7},{11, 13.9},  {24, 33},    {13.9, 13.9}}};  // m/s
constexpr OfKinds kPeople     {{{0, 1.5},    {1, 6},      {4, 14},     {5, 16},     {4, 14},     {1, 5},      {1, 4},      {0, 0},      {8, 12}}};  // per 100 m
constexpr OfKinds kClutter    {{{1, 4},      {3, 9},      {6, 16},     {8, 18},     {6, 16},     {2, 7},      {2, 6},      {0, 0.5},    {8, 12}}};  // per 100 m
constexpr OfKinds kLights     {{{0, 0},      {0.15, 0.15},{0.6, 0.6},  {0.8, 0.8},  {0, 0},      {0.7, 0.7},  {0.5, 0.5},  {0, 0},      {1, 1}}};
}  // namespace property
// clang-format on

// The kinds of successive seeds, so that any sixteen of them have each kind and most are residential.
constexpr std::array<District, 16> kOrder{
    District::Suburban,   District::Arterial, District::Suburban,   District::Rural,
    District::Commercial, District::Dense,    District::Suburban,   District::Boulevard,
    District::Motorway,   District::Suburban, District::OldTown,    District::Arterial,
    District::Suburban,   District::Rural,    District::Commercial, District::Dense};

// Returns the index of the kind in kDistricts.
std::size_t districtOf(const Parameters& p, std::uint64_t seed) {
  const auto* const named = std::ranges::find(kDistricts, p.district, &DistrictTraits::name);
  if (named != kDistricts.end()) return static_cast<std::size_t>(named - kDistricts.begin());
  return static_cast<std::size_t>(kOrder[(seed + kOrder.size() - 1) % kOrder.size()]);
}

}  // namespace

Parameters readParameters(Fields& fields) {
  Parameters p;
  std::vector<std::string> districts{"any"};
  for (const DistrictTraits& district : kDistricts) districts.emplace_back(district.name);
  p.district = fields.choice("district", districts, p.district);
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

// The random stream draws the properties in the order of the code.
Character::Character(const Parameters& p, std::uint64_t seed) : DistrictTraits(kDistricts[districtOf(p, seed)]) {
  Draw draw(seed, Kind::Town);
  const auto of = [district = districtOf(p, seed)](const OfKinds& property) { return property[district]; };
  main.lanes = of(property::kLanes).integerOf(draw);
  main.shoulder = of(property::kShoulder).low;
  main.median = of(property::kMedian).of(draw);
  main.parking = draw.chance(of(property::kBays).low) ? draw.in(1.9, 2.4) : 0;
  main.half = main.median + main.lanes * of(property::kLane).of(draw) + main.shoulder + main.parking;
  main.sidewalk = draw.chance(of(property::kWalks).low) ? of(property::kSidewalk).of(draw) : 0;
  main.curb = main.sidewalk > 0 ? 0.15 : 0;
  const double step = of(property::kStep).of(draw);
  main.step = main.sidewalk > 0 ? step : 0;
  main.verge = draw.chance(of(property::kGrassy).low) ? of(property::kVerge).of(draw) : 0;
  main.apron = main.sidewalk > 0 ? of(property::kApron).of(draw) : 0;
  side = main;
  side.lanes = 1;
  side.median = side.shoulder = 0;
  side.parking = country || of(property::kBays).low == 0 ? 0 : draw.chance(0.3) ? draw.in(1.9, 2.3) : 0;
  side.half = std::min(of(property::kLane).of(draw), 3.6) + side.parking;
  side.verge *= draw.in(0, 1);
  side.sidewalk *= draw.in(0.7, 1.0);
  sideRoads = of(property::kSideRoads).integerOf(draw);
  bend = of(property::kBend).of(draw);
  hills = p.slope * of(property::kHills).of(draw);
  banks = p.slope * of(property::kBanks).of(draw);
  undulation = of(property::kUndulation).of(draw);
  setback = of(property::kSetback).of(draw);
  setbackSpread = setback * draw.in(0.1, 0.6);
  built = of(property::kBuilt).of(draw);
  plotWidth = of(property::kPlotWidth).of(draw);
  floorsLow = static_cast<int>(of(property::kFloors).low);
  floorsHigh = static_cast<int>(of(property::kFloors).high);
  const double green = p.greenery * draw.in(0.6, 1.5);
  hedges = std::min(0.9, green * of(property::kHedges).of(draw));
  fences = std::min(1 - hedges, of(property::kFences).of(draw));
  avenue = std::min(1.0, green * of(property::kAvenue).of(draw));
  gardenTrees = green * of(property::kTrees).of(draw);
  gardenBushes = green * of(property::kBushes).of(draw);
  woods = std::min(0.95, green * of(property::kWoods).of(draw));
  forecourts = of(property::kForecourts).of(draw);
  // Few places are full of parked vehicles.
  const double full = draw.next();
  parked =
      std::min(0.95, p.vehicles * models::lerp(of(property::kParked).low, of(property::kParked).high, full * full));
  traffic = p.vehicles * p.traffic * of(property::kTraffic).of(draw);
  speed = of(property::kSpeed).of(draw);
  people = p.people * of(property::kPeople).of(draw);
  clutter = of(property::kClutter).of(draw);
  lights = of(property::kLights).low;
  drawSeason(p, seed);
}

// The season has its own random stream, so that everything else is the same in all seasons.
void Character::drawSeason(const Parameters& p, std::uint64_t seed) {
  Draw sky(seed, Kind::Season);
  const double pick = sky.next();
  const auto isSeason = [&](const char* wanted, double low, double high) {
    return p.season == "any" ? pick >= low && pick < high : p.season == wanted;
  };
  season = isSeason("autumn", 0.5, 0.75) ? Season::Autumn
           : isSeason("winter", 0.75, 1) ? Season::Winter
                                         : Season::Summer;
  wear = sky.next() * sky.next() * (plain ? 0 : 1);
  if (season == Season::Autumn) foliage = sky.in(0.15, 0.7);
  if (season == Season::Winter) {
    foliage = 0.03;
    snow = sky.in(0.04, 0.25);
    snowBanks = sky.in(0.2, 0.7);
  }
}

std::string Character::inWords() const {
  const char* const time = season == Season::Summer ? "summer" : season == Season::Autumn ? "autumn" : "winter";
  return fmt::format("{}, {}", name, time);
}

}  // namespace scanmill::town
