#include "town/character.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace scanmill::town {
namespace {

using models::Kind;

// The interval from which a property of a town is drawn.
struct Between {
  double low = 0, high = 0;
};

// The kinds of districts. The seed selects any district except Street.
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

// Widths and speeds follow the German guidelines for urban roads (RASt 06), rural roads (RAL) and motorways (RAA):
// lanes of 2.75 to 3.75 m, or wider without a parking lane, sidewalks of at least 2.5 m, shoulders of 2.5 m. All other
// values are estimates. Values without a unit are fractions or numbers; see Character.
// clang-format off
namespace property {
//                               rural        suburban     dense        boulevard    old_town     arterial     commercial   motorway     street
constexpr OfKinds kLanes      {{{1, 1},      {1, 1},      {1, 1},      {2, 2},      {1, 1},      {1, 2},      {1, 1},      {2, 3},      {1, 1}}};  // in each direction
constexpr OfKinds kLane       {{{2.8, 3.5},  {4, 5.4},    {3.4, 4.4},  {3, 3.4},    {2.2, 2.8},  {3.8, 4.8},  {4.2, 5.5},  {3.5, 3.75}, {3.5, 3.5}}};  // m, width
constexpr OfKinds kShoulder   {{{0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {2.5, 2.5},  {0, 0}}};  // m
constexpr OfKinds kMedian     {{{0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0, 0},      {0.6, 1.5},  {0, 0}}};  // m, half of the width
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
constexpr OfKinds kTrees      {{{0.6, 2.2},  {1.5, 3.5},  {0.1, 0.7},  {0.1, 0.6},  {0.1, 0.7},  {1, 2.5},    {0.3, 1.2},  {0.5, 3},    {0.5, 1}}};
constexpr OfKinds kBushes     {{{2, 6},      {0, 3},      {0, 0.8},    {0, 0.4},    {0, 0.6},    {1, 5},      {1, 4},      {1, 6},      {2, 3}}};
constexpr OfKinds kWoods      {{{0.3, 0.8},  {0.4, 0.8},  {0.05, 0.3}, {0.05, 0.2}, {0.05, 0.3}, {0.5, 0.85}, {0.3, 0.7},  {0.3, 0.8},  {0, 0}}};
constexpr OfKinds kForecourts {{{0.2, 0.6},  {0.6, 0.95}, {0, 0},      {0, 0},      {0, 0},      {0.5, 0.9},  {0.7, 1},    {0, 0},      {0, 0}}};
constexpr OfKinds kParked     {{{0, 0.1},    {0.2, 0.6},  {0.15, 0.6}, {0.5, 1},    {0.1, 0.5},  {0.05, 0.4}, {0.2, 0.7},  {0, 0},      {0.3, 0.3}}};
constexpr OfKinds kTraffic    {{{0.05, 2},   {0.1, 4},    {0.1, 4},    {0.1, 3},    {0.05, 1},   {0.2, 4},    {0.2, 4},    {0.4, 2.5},  {3, 3}}};  // per 100 m and lane
constexpr OfKinds kSpeed      {{{15, 24},    {8.3, 13.9}, {8.3, 13.9}, {11, 13.9},  {5, 8.3},    {13.9, 16.7},{11, 13.9},  {24, 33},    {13.9, 13.9}}};  // m/s
constexpr OfKinds kPeople     {{{0, 1.5},    {1, 6},      {4, 14},     {5, 16},     {4, 14},     {1, 5},      {1, 4},      {0, 0},      {8, 12}}};  // per 100 m
constexpr OfKinds kClutter    {{{1, 4},      {3, 9},      {6, 16},     {8, 18},     {6, 16},     {2, 7},      {2, 6},      {0, 0.5},    {8, 12}}};  // per 100 m
constexpr OfKinds kLights     {{{0, 0},      {0.15, 0.15},{0.6, 0.6},  {0.8, 0.8},  {0, 0},      {0.7, 0.7},  {0.5, 0.5},  {0, 0},      {1, 1}}};
}  // namespace property
// clang-format on

// The districts of successive seeds. Any sixteen successive seeds have all districts but Street; suburbs are frequent.
constexpr std::array<District, 16> kOrder{
    District::Suburban,   District::Arterial, District::Suburban,   District::Rural,
    District::Commercial, District::Dense,    District::Suburban,   District::Boulevard,
    District::Motorway,   District::Suburban, District::OldTown,    District::Arterial,
    District::Suburban,   District::Rural,    District::Commercial, District::Dense};

// Returns the index in kDistricts of the district that `p` names or, for "any", of the district that the seed selects.
std::size_t districtOf(const Parameters& p, std::uint64_t seed) {
  const auto* const district = std::ranges::find(kDistricts, p.district, &DistrictTraits::name);
  if (district != kDistricts.end()) return static_cast<std::size_t>(district - kDistricts.begin());
  return static_cast<std::size_t>(kOrder[(seed + kOrder.size() - 1) % kOrder.size()]);
}

// Draws random properties from the intervals of a district.
struct PropertyDraw {
  Draw& draw;
  std::size_t district;  // index in kDistricts

  const Between& interval(const OfKinds& property) const { return property[district]; }
  double number(const OfKinds& property) const { return draw.in(interval(property).low, interval(property).high); }
  // Returns a random integer in a property's interval, both ends included.
  int integer(const OfKinds& property) const {
    const int low = static_cast<int>(interval(property).low);
    return low + draw.below(static_cast<int>(interval(property).high - low) + 1);
  }
  bool chance(const OfKinds& probability) const { return draw.chance(interval(probability).low); }
};

// Returns a random cross section of the main road.
CrossSection drawMainSection(const PropertyDraw& random) {
  CrossSection s;
  s.lanes = random.integer(property::kLanes);
  s.shoulder = random.interval(property::kShoulder).low;
  s.median = random.number(property::kMedian);
  s.parking = random.chance(property::kBays) ? random.draw.in(1.9, 2.4) : 0;
  s.half = s.median + s.lanes * random.number(property::kLane) + s.shoulder + s.parking;
  s.sidewalk = random.chance(property::kWalks) ? random.number(property::kSidewalk) : 0;
  s.curb = s.sidewalk > 0 ? 0.15 : 0;
  const double step = random.number(property::kStep);
  s.step = s.sidewalk > 0 ? step : 0;
  s.verge = random.chance(property::kGrassy) ? random.number(property::kVerge) : 0;
  s.apron = s.sidewalk > 0 ? random.number(property::kApron) : 0;
  return s;
}

// Returns a random cross section of side roads. `s`: the main road's cross section. Side roads differ from `s` by one
// lane in each direction, other parking lanes, and narrower verges and sidewalks.
CrossSection drawSideSection(const PropertyDraw& random, CrossSection s, bool country) {
  constexpr double kWidestLane = 3.6;  // m
  const bool hasBays = !country && random.interval(property::kBays).low > 0;
  s.lanes = 1;
  s.median = s.shoulder = 0;
  s.parking = hasBays && random.draw.chance(0.3) ? random.draw.in(1.9, 2.3) : 0;
  s.half = std::min(random.number(property::kLane), kWidestLane) + s.parking;
  s.verge *= random.draw.in(0, 1);
  s.sidewalk *= random.draw.in(0.7, 1.0);
  return s;
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

// All properties are drawn from one random stream: their order decides what a seed generates.
Character::Character(const Parameters& p, std::uint64_t seed) : DistrictTraits(kDistricts[districtOf(p, seed)]) {
  Draw draw(seed, Kind::Town);
  const PropertyDraw random{draw, districtOf(p, seed)};
  main = drawMainSection(random);
  side = drawSideSection(random, main, country);
  sideRoads = random.integer(property::kSideRoads);
  bend = random.number(property::kBend);
  hills = p.slope * random.number(property::kHills);
  banks = p.slope * random.number(property::kBanks);
  undulation = random.number(property::kUndulation);
  setback = random.number(property::kSetback);
  setbackSpread = setback * draw.in(0.1, 0.6);
  built = random.number(property::kBuilt);
  plotWidth = random.number(property::kPlotWidth);
  floorsLow = static_cast<int>(random.interval(property::kFloors).low);
  floorsHigh = static_cast<int>(random.interval(property::kFloors).high);
  const double green = p.greenery * draw.in(0.6, 1.5);  // factor on all plants
  hedges = std::min(0.9, green * random.number(property::kHedges));
  fences = std::min(1 - hedges, random.number(property::kFences));
  avenue = std::min(1.0, green * random.number(property::kAvenue));
  gardenTrees = green * random.number(property::kTrees);
  gardenBushes = green * random.number(property::kBushes);
  woods = std::min(0.95, green * random.number(property::kWoods));
  forecourts = random.number(property::kForecourts);
  const double fullness = draw.next();  // squared below: few towns are full of parked vehicles
  const auto& [leastParked, mostParked] = random.interval(property::kParked);
  parked = std::min(0.95, p.vehicles * models::lerp(leastParked, mostParked, fullness * fullness));
  const double business = draw.next();  // cubed below: half of the towns are nearly without traffic, few are busy
  const auto& [leastTraffic, mostTraffic] = random.interval(property::kTraffic);
  traffic = p.vehicles * p.traffic * models::lerp(leastTraffic, mostTraffic, business * business * business);
  speed = random.number(property::kSpeed);
  people = p.people * random.number(property::kPeople);
  clutter = random.number(property::kClutter);
  lights = random.interval(property::kLights).low;
  drawSeason(p, seed);
}

// Uses a separate random stream, so that a town differs between seasons only in the properties set here.
void Character::drawSeason(const Parameters& p, std::uint64_t seed) {
  Draw draw(seed, Kind::Season);
  const double share = draw.next();
  const std::string_view drawn = share < 0.5 ? "summer" : share < 0.75 ? "autumn" : "winter";
  const std::string_view seasonName = p.season == "any" ? drawn : std::string_view(p.season);
  season = seasonName == "autumn" ? Season::Autumn : seasonName == "winter" ? Season::Winter : Season::Summer;
  wear = draw.next() * draw.next() * (plain ? 0 : 1);
  if (season == Season::Autumn) foliage = draw.in(0.15, 0.7);
  if (season == Season::Winter) {
    foliage = 0.03;
    snow = draw.in(0.04, 0.25);
    snowBanks = draw.in(0.2, 0.7);
  }
}

std::string Character::inWords() const {
  const char* const time = season == Season::Summer ? "summer" : season == Season::Autumn ? "autumn" : "winter";
  return fmt::format("{}, {}", name, time);
}

}  // namespace scanmill::town
