#include <fmt/format.h>

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>
#include <map>
#include <utility>

#include "town/map.h"

namespace scanmill::town {
namespace {

namespace gtl = boost::polygon;
using Region = gtl::polygon_set_data<int>;

constexpr double kStorey = 2.9;            // m, usual height of a storey
constexpr double kSlope = 0.75;            // usual slope of a pitched roof
constexpr double kWideSlope = kSlope / 3;  // usual slope of a pitched roof wider than kWidest, as of halls
constexpr double kWidest = 18;             // m; wider buildings have no pitched roof unless the map gives it
constexpr double kHighest = 1000;          // m, greatest height that tags may give
constexpr double kMostFloors = 200;        // greatest number of floors that tags may give
constexpr double kUnit = 1e-3;             // m per unit of the integer coordinates of Boost.Polygon

enum class RoofShape { Flat, Gabled, Hipped, Pyramidal, Skillion };

struct RoofEntry {
  std::string_view name;  // value of roof:shape
  RoofShape built;
  std::string_view as;  // name of the shape that is built instead; empty: the shape itself is built
};

constexpr RoofEntry kRoofs[] = {
    {"flat", RoofShape::Flat, ""},
    {"gabled", RoofShape::Gabled, ""},
    {"hipped", RoofShape::Hipped, ""},
    {"pyramidal", RoofShape::Pyramidal, ""},
    {"skillion", RoofShape::Skillion, ""},
    {"half-hipped", RoofShape::Gabled, "gabled"},
    {"side_hipped", RoofShape::Gabled, "gabled"},
    {"cross_gabled", RoofShape::Gabled, "gabled"},
    {"gambrel", RoofShape::Gabled, "gabled"},
    {"saltbox", RoofShape::Gabled, "gabled"},
    {"double_saltbox", RoofShape::Gabled, "gabled"},
    {"round", RoofShape::Gabled, "gabled"},
    {"mansard", RoofShape::Hipped, "hipped"},
    {"dome", RoofShape::Pyramidal, "pyramidal"},
    {"onion", RoofShape::Pyramidal, "pyramidal"},
    {"cone", RoofShape::Pyramidal, "pyramidal"},
};

// The axis along which a roof slopes: x or y of the rectangle about the building.
struct RoofDirection {
  bool alongX;
  double highSide;  // 1 or -1: end of this axis at which a skillion (single-slope) roof is high
};

// Returns the direction of slope from the tag roof:direction; without the tag, towards the longer sides or, if
// roof:orientation is `across`, towards the shorter sides.
RoofDirection roofDirection(const OsmTags& tags, const models::Footprint& about, bool mirrored, TagNumbers& numbers) {
  const auto direction = numbers.read(tags, "roof:direction", compassOf, 0, 360);
  if (!direction) return {(about.halfX < about.halfY) != (tags["roof:orientation"] == "across"), 1};
  const double east = std::sin(radians(*direction));
  const double north = std::cos(radians(*direction)) * (mirrored ? -1 : 1);
  const double downX = east * std::cos(about.yaw) + north * std::sin(about.yaw);
  const double downY = north * std::cos(about.yaw) - east * std::sin(about.yaw);
  const bool alongX = std::abs(downX) > std::abs(downY);
  return {alongX, (alongX ? downX : downY) > 0 ? -1.0 : 1.0};
}

// Sets the ridge and the height of a pitched roof and, if houses can have the shape, b.roof. `about`: rectangle about
// the building; `slope`: m/m. Replaces an outline that does not have four corners by `about`, except below a pyramid.
void setPitchedRoof(MapBuilding& b, const models::Footprint& about, RoofShape shape, RoofDirection direction,
                    double slope) {
  constexpr double kSquare = 0.1;  // largest difference of a square's half sides, divided by the smaller one
  const double shorter = std::min(about.halfX, about.halfY);
  const bool square = std::abs(about.halfX - about.halfY) < kSquare * shorter;
  const bool downShorterSide = direction.alongX == (about.halfX < about.halfY);
  if (shape == RoofShape::Hipped && !downShorterSide) {
    direction.alongX = !direction.alongX;
    if (std::abs(about.halfX - about.halfY) > kSquare * shorter) {
      b.difference = "hipped roofs with a ridge across, whose ridge is along the longer side";
    }
  }
  const double run = direction.alongX ? about.halfX : about.halfY;  // m, from the eaves to the middle
  const double halfLength = direction.alongX ? about.halfY : about.halfX;
  // Half of the length of the ridge, and its distance from the middle (m).
  const double halfRidge = shape == RoofShape::Pyramidal ? 0
                           : shape == RoofShape::Hipped  ? std::max(0.0, halfLength - run)
                                                         : halfLength;
  const double offset = shape == RoofShape::Skillion ? direction.highSide * run : 0;
  b.ridge = direction.alongX ? std::array{about.at(offset, -halfRidge), about.at(offset, halfRidge)}
                             : std::array{about.at(-halfRidge, offset), about.at(halfRidge, offset)};
  b.rise = slope * (shape == RoofShape::Gabled || shape == RoofShape::Skillion ? run : shorter);
  if (shape == RoofShape::Gabled) b.roof = models::Roof::Gable;
  if (shape == RoofShape::Hipped || (shape == RoofShape::Pyramidal && square)) b.roof = models::Roof::Hip;
  if (shape != RoofShape::Pyramidal && b.outline.size() != 4) b.outline = cornersOf(about);
}

// Sets the roof's shape and height from the tags; without a known shape, only the height for a randomly drawn shape.
void setRoof(MapBuilding& b, const OsmTags& tags, bool mirrored, TagNumbers& numbers) {
  const models::Footprint about = rectangleAbout(b.outline);
  const double halfWidth = std::min(about.halfX, about.halfY);
  const bool wide = 2 * halfWidth >= kWidest;
  const bool rectangular = isRectangular(b.outline, about);
  const auto* const entry = std::ranges::find(kRoofs, tags["roof:shape"], &RoofEntry::name);
  const auto angle = numbers.read(tags, "roof:angle", numberOf, 1, 85);  // degrees
  const double slope = angle ? std::tan(radians(*angle)) : wide ? kWideSlope : kSlope;
  if (entry == std::end(kRoofs)) {
    if (!tags["roof:shape"].empty()) b.difference = "roofs with an unknown roof:shape, which the seed draws";
    if (rectangular && !wide) b.rise = slope * halfWidth;
    b.riseMapped = angle && b.rise > 0;
    return;
  }
  if (!entry->as.empty()) {
    b.difference = fmt::format("roofs with roof:shape={}, which are built {}", entry->name, entry->as);
  }
  RoofShape shape = entry->built;
  const bool pyramid = shape == RoofShape::Pyramidal && isInside({&b.outline}, about.center);
  if (shape != RoofShape::Flat && (!b.courts.empty() || (!rectangular && !pyramid))) {
    b.difference = "pitched roofs over outlines that are no rectangles, which are built flat";
    shape = RoofShape::Flat;
  }
  if (shape == RoofShape::Flat) {
    b.roof = models::Roof::Flat;
    return;
  }
  b.riseMapped = angle.has_value();
  setPitchedRoof(b, about, shape, roofDirection(tags, about, mirrored, numbers), slope);
  if (angle && shape == RoofShape::Skillion) b.rise *= 2;  // a skillion roof rises over the complete width
}

// Replaces the height of the roof that setRoof() has set, if the tags give the height or if it does not fit below
// b.top. Returns the height of the roof without the limit by b.top (m).
double setRise(MapBuilding& b, const OsmTags& tags, TagNumbers& numbers) {
  constexpr double kWallBelow = 2;  // m of wall below a roof of usual height, unless the roof is half of the building
  std::optional<double> mapped = numbers.read(tags, "roof:height", metresOf, 0, kHighest);
  const auto roofLevels = numbers.read(tags, "roof:levels", numberOf, 0, kMostFloors);
  if (!mapped && roofLevels.value_or(0) > 0) mapped = kStorey * *roofLevels;
  const double unlimited = mapped.value_or(b.rise);
  if (b.roof == models::Roof::Flat || (tags["building"].empty() && !b.ridge)) {
    b.rise = 0;
    b.riseMapped = false;
  } else if (mapped) {
    b.rise = *mapped;
    b.riseMapped = true;
  } else if (b.top) {
    b.rise = std::min(b.rise, b.riseMapped ? *b.top : std::max(*b.top / 2, *b.top - kWallBelow));
  }
  return unlimited;
}

// Sets floors, top, base and the height of the roof from the tags. Must be called after setRoof().
void setHeights(MapBuilding& b, const OsmTags& tags, TagNumbers& numbers) {
  const auto floors = numbers.read(tags, "building:levels", numberOf, 0.5, kMostFloors);
  if (floors) b.floors = static_cast<int>(std::lround(*floors));
  for (const char* const key : {"height", "building:height", "est_height"}) {
    if (!b.top) b.top = numbers.read(tags, key, metresOf, 0.1, kHighest);
  }
  const double unlimitedRise = setRise(b, tags, numbers);
  const auto base = numbers.read(tags, "min_height", metresOf, 0, kHighest);
  const auto level = numbers.read(tags, "building:min_level", numberOf, 0, kMostFloors);
  const double storey = b.top && floors ? std::max(*b.top - b.rise, 0.0) / *floors : kStorey;
  b.base = base ? *base : level ? storey * *level : 0;
  if (b.difference.empty() && b.riseMapped && b.top && unlimitedRise > *b.top - b.base + 0.05) {
    b.difference = "roofs higher than their buildings by roof:height or roof:angle, which end at the building's foot";
  }
  // Houses and blocks without a top have storeys of random height. The top of a part and of a building with a base or a
  // mapped roof must agree with the other heights of the map, and follows from the floors.
  if (!b.top && floors && (tags["building"].empty() || b.base > 0 || b.riseMapped)) {
    b.top = kStorey * *floors + (b.ridge || b.riseMapped ? b.rise : 0);
  }
}

// Returns the ground plan of a building in units of kUnit, relative to `origin`.
Region regionOf(const MapBuilding& b, const Point2& origin) {
  const auto ring = [&](const Polygon& points) {
    std::vector<gtl::point_data<int>> corners;
    for (const Point2& p : points) {
      corners.emplace_back(static_cast<int>(std::lround((p.x - origin.x) / kUnit)),
                           static_cast<int>(std::lround((p.y - origin.y) / kUnit)));
    }
    return gtl::polygon_data<int>(corners.begin(), corners.end());
  };
  Region region;
  region.insert(ring(b.outline));
  for (const Polygon& court : b.courts) region.insert(ring(court), true);
  return region;
}

double squareMetres(const Region& region) {
  return kUnit * kUnit * static_cast<double>(gtl::area(region));
}

// Returns the area (m^2) of the intersection of two ground plans.
double overlap(const MapBuilding& a, const MapBuilding& b) {
  using namespace gtl::operators;
  const Point2& origin = a.outline.front();
  return squareMetres(Region(regionOf(a, origin) & regionOf(b, origin)));
}

template <class Ring>
Polygon polygonOf(const Ring& ring, const Point2& origin) {
  Polygon polygon;
  for (auto p = gtl::begin_points(ring); p != gtl::end_points(ring); ++p) {
    polygon.push_back({origin.x + kUnit * gtl::x(*p), origin.y + kUnit * gtl::y(*p)});
  }
  return polygon;
}

// Adds a part for each uncovered region of the outline; if parts cover nearly all of it, adds none and returns false.
bool addUncoveredRegions(MapBuilding& b) {
  constexpr double kCovered = 0.9;    // fraction of an outline; parts that cover more leave nothing to add
  constexpr double kLeastRegion = 1;  // m^2
  using namespace gtl::operators;
  const Point2 origin = b.outline.front();
  Region uncovered = regionOf(b, origin);
  const double totalArea = squareMetres(uncovered);
  for (const MapBuilding& part : b.parts) uncovered -= regionOf(part, origin);
  if (squareMetres(uncovered) <= (1 - kCovered) * totalArea) return false;
  // Removes strips thinner than 2 * kSeam between outline and parts: shrinks the region by kSeam, then grows it again.
  constexpr int kSeam = 80;  // units of kUnit; larger than the errors by ringOf() and by rounded degrees
  Region withoutStrips = uncovered;
  withoutStrips.resize(-kSeam);
  withoutStrips.resize(kSeam);
  uncovered &= withoutStrips;
  std::vector<gtl::polygon_with_holes_data<int>> pieces;
  uncovered.get(pieces);
  for (const auto& piece : pieces) {
    MapBuilding part;
    part.outline = polygonOf(piece, origin);
    if (part.outline.size() < 3 || areaOf(part.outline) < kLeastRegion) continue;
    for (auto hole = gtl::begin_holes(piece); hole != gtl::end_holes(piece); ++hole) {
      part.courts.push_back(polygonOf(*hole, origin));
    }
    part.base = b.base;
    part.top = b.top;
    part.floors = b.floors;
    part.shop = b.shop;
    b.parts.push_back(std::move(part));
  }
  return true;
}

// Finds the building that a part belongs to.
class OwnerFinder {
 public:
  explicit OwnerFinder(const std::vector<MapBuilding>& buildings) : buildings_(buildings) {
    for (std::size_t i = 0; i < buildings.size(); ++i) {
      extents_.push_back(extentOf(buildings[i].outline));
      byWest_.emplace_back(extents_[i].low.x, i);
      widest_ = std::max(widest_, extents_[i].high.x - extents_[i].low.x);
      if (buildings[i].relation != 0) byRelation_[buildings[i].relation].push_back(i);
    }
    std::sort(byWest_.begin(), byWest_.end());
  }

  // Returns the index of a part's building: the building in the part's relation with the largest overlap or, if none is
  // in the relation, the building that contains most of the part and at least half; nullopt if there is no building.
  std::optional<std::size_t> operator()(const MapBuilding& part) const {
    std::optional<std::size_t> owner;
    double largestOverlap = 0;
    const auto consider = [&](std::size_t i, double leastOverlap) {
      const double area = overlap(part, buildings_[i]);
      if (area < leastOverlap || (owner && area <= largestOverlap)) return;
      owner = i;
      largestOverlap = area;
    };
    const auto related = byRelation_.find(part.relation);
    if (part.relation != 0 && related != byRelation_.end()) {
      for (const std::size_t i : related->second) consider(i, 0);
      return owner;
    }
    const Extent extent = extentOf(part.outline);
    // Buildings whose west end is more than widest_ west of the part's west end cannot overlap the part.
    auto entry = std::lower_bound(byWest_.begin(), byWest_.end(), std::pair(extent.low.x - widest_, std::size_t{0}));
    for (; entry != byWest_.end() && entry->first < extent.high.x; ++entry) {
      const auto& [low, high] = extents_[entry->second];
      const bool apart = high.x < extent.low.x || high.y < extent.low.y || low.y > extent.high.y;
      if (!apart) consider(entry->second, areaOf(part.outline) / 2);
    }
    return owner;
  }

 private:
  const std::vector<MapBuilding>& buildings_;
  std::vector<Extent> extents_;                                  // by building
  std::vector<std::pair<double, std::size_t>> byWest_;           // (west end (m), index of the building), sorted
  std::map<std::int64_t, std::vector<std::size_t>> byRelation_;  // indices of buildings
  double widest_ = 0;                                            // m, largest extent of a building from west to east
};

}  // namespace

std::optional<double> MapBuilding::eaves() const {
  constexpr double kLowest = 2;  // m, lowest eaves if the map does not give them
  if (!top) return std::nullopt;
  return std::max(*top - rise, base > 0 ? base : riseMapped ? std::min(*top, 0.1) : std::min(*top, kLowest));
}

std::optional<int> MapBuilding::usualFloors() const {
  constexpr double kLeast = 2.4;
  if (floors && top) return std::min(*floors, std::max(1, static_cast<int>(*top / kLeast)));
  if (floors) return floors;
  return top ? std::optional(std::max(1, static_cast<int>(std::lround(*eaves() / kStorey)))) : std::nullopt;
}

bool isRectangular(const Polygon& outline, const models::Footprint& about) {
  constexpr double kSkewed = 0.9, kCutOut = 0.98;  // least covered fractions of the rectangle
  return areaOf(outline) > (outline.size() == 4 ? kSkewed : kCutOut) * 4 * about.halfX * about.halfY;
}

MapBuilding makeBuilding(const OsmTags& tags, Polygon outline, std::vector<Polygon> courts, bool mirrored,
                         TagNumbers& numbers) {
  MapBuilding building;
  building.outline = std::move(outline);
  building.courts = std::move(courts);
  setRoof(building, tags, mirrored, numbers);
  setHeights(building, tags, numbers);
  constexpr double kLow = 2.6;  // m, top of the highest building that is too low for windows
  building.shop = !tags["shop"].empty() || isOneOf(tags["building"], {"retail", "supermarket", "commercial"});
  building.shed = isOneOf(tags["building"],
                          {"garage", "garages", "shed", "hut", "greenhouse", "service", "barn", "farm_auxiliary"}) ||
                  building.top.value_or(kLow) < kLow;
  return building;
}

void joinParts(std::vector<MapBuilding>& buildings, std::vector<MapBuilding> parts, LeftOut& leftOut) {
  const OwnerFinder ownerOf(buildings);
  std::vector<MapBuilding> unowned;
  std::vector<std::pair<std::size_t, MapBuilding>> owned;  // (index of the building, part)
  for (MapBuilding& part : parts) {
    if (const std::optional<std::size_t> owner = ownerOf(part)) {
      owned.emplace_back(*owner, std::move(part));
    } else {
      unowned.push_back(std::move(part));
    }
  }
  for (auto& [owner, part] : owned) {
    // A part for which the map gives neither top nor floors is as high as the building.
    MapBuilding& building = buildings[owner];
    if (!part.top && !part.floors) {
      part.top = building.top;
      part.floors = building.floors;
    }
    building.parts.push_back(std::move(part));
  }
  buildings.insert(buildings.end(), std::make_move_iterator(unowned.begin()), std::make_move_iterator(unowned.end()));
  // If the base is above the ground, sets a missing top. Returns true, and counts the building as left out, if the top
  // is not above the base; otherwise counts b.difference and returns false.
  const auto countAndTestHeight = [&](MapBuilding& b) {
    if (b.base > 0 && !b.top) b.top = b.base + kStorey;
    const bool flat = b.base > 0 && *b.top < b.base + 0.05;
    if (flat) leftOut.add("buildings and building parts that are no higher than their min_height");
    if (!flat && !b.difference.empty()) leftOut.add(b.difference);
    return flat;
  };
  for (MapBuilding& building : buildings) {
    if (building.parts.empty()) continue;
    if (addUncoveredRegions(building)) {
      leftOut.add("building outlines that their parts cover in part, and that are built beside them");
    }
    std::erase_if(building.parts, countAndTestHeight);
  }
  std::erase_if(buildings, [&](MapBuilding& b) { return b.parts.empty() && countAndTestHeight(b); });
}

}  // namespace scanmill::town
