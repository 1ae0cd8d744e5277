#include "town/map.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "base/earth.h"
#include "town/osm_interface.h"

namespace scanmill::town {
namespace {

// The plane that touches the WGS 84 ellipsoid at a point (degrees). Coordinates are metres from that point: x east, y
// north (south if mirrored). Conversion uses earth-centred coordinates; 25 km from the point, distances in the plane
// are 0.1 m too short.
class TangentPlane {
 public:
  TangentPlane(double latitude, double longitude, bool mirrored)
      : latitude_(radians(latitude)),
        longitude_(radians(longitude)),
        north_(mirrored ? -1 : 1),
        origin_(earthCentred(longitude_, latitude_, 0)) {}

  Point2 operator()(const OsmNode& n) const {
    const Vec3d d = earthCentred(radians(n.longitude), radians(n.latitude), 0) - origin_;
    const double towards = d.x * std::cos(longitude_) + d.y * std::sin(longitude_);
    return {d.y * std::cos(longitude_) - d.x * std::sin(longitude_),
            north_ * (d.z * std::cos(latitude_) - towards * std::sin(latitude_))};
  }
  bool mirrored() const { return north_ < 0; }

  // Returns the latitude and longitude (degrees) of a point in the plane: the inverse of operator(). Solves by Newton's
  // method with an approximate derivative: anywhere in the plane, a metre to the north or east is about the same number
  // of degrees.
  OsmNode degreesAt(const Point2& p) const {
    constexpr double kDegree = 111300;  // m, length of a degree of latitude
    OsmNode node{0, degrees(latitude_), degrees(longitude_)};
    for (int i = 0; i < 12; ++i) {
      const Point2 now = (*this)(node);
      node.latitude += north_ * (p.y - now.y) / kDegree;
      node.longitude += (p.x - now.x) / (kDegree * std::max(0.01, std::cos(latitude_)));
    }
    return node;
  }

 private:
  double latitude_, longitude_;  // rad
  double north_;                 // sign of y towards the north: 1, or -1 if mirrored
  Vec3d origin_;
};

bool isOneOf(std::string_view value, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), value) != words.end();
}

std::optional<RoadClass> classOf(const OsmTags& tags) {
  std::string_view value = tags["highway"];
  if (value.ends_with("_link")) value.remove_suffix(5);
  if (isOneOf(value, {"motorway", "trunk", "primary"})) return RoadClass::Primary;
  if (value == "secondary") return RoadClass::Secondary;
  if (value == "tertiary") return RoadClass::Tertiary;
  if (isOneOf(value, {"residential", "unclassified", "living_street", "road"})) return RoadClass::Residential;
  if (value == "service") return RoadClass::Service;
  if (value == "track") return RoadClass::Track;
  return std::nullopt;
}

bool isPath(const OsmTags& tags) {
  // Footways that are pavements are left out, since they are part of their roads.
  return isOneOf(tags["highway"], {"footway", "path", "cycleway", "steps", "bridleway"}) &&
         !isOneOf(tags["footway"], {"sidewalk", "crossing", "traffic_island"}) && tags["path"] != "sidewalk" &&
         tags["is_sidepath"] != "yes";
}

// True if an object is on the ground. Objects that are not, such as tunnels and bridges, are left out.
bool onGround(const OsmTags& tags) {
  return isOneOf(tags["tunnel"], {"", "no"}) && isOneOf(tags["indoor"], {"", "no"}) &&
         isOneOf(tags["bridge"], {"", "no"}) && !tags["layer"].starts_with("-") &&
         !isOneOf(tags["location"], {"underground", "overground", "indoor", "roof"});
}

// Returns whether a road has a feature, from tags with keys such as `sidewalk`, `parking:lane:both` or `parking:left`:
// true if the value of a key is in `yes`; otherwise false if a value is in `no`; nullopt if no value is in either list.
std::optional<bool> saidOf(const OsmTags& tags, std::initializer_list<const char*> keys,
                           std::initializer_list<std::string_view> yes, std::initializer_list<std::string_view> no) {
  std::optional<bool> said;
  for (const char* key : keys) {
    if (isOneOf(tags[key], yes)) return true;
    if (isOneOf(tags[key], no)) said = false;
  }
  return said;
}

MapRoad roadOf(const OsmWay& way, RoadClass kind, const TangentPlane& plane) {
  constexpr double kLane = 3.1;  // m, width of a lane if the map gives only the number of lanes
  MapRoad road;
  road.kind = kind;
  road.name = way.tags["name"];
  for (const OsmNode& n : way.nodes) {
    const Point2 p = plane(n);
    if (!road.line.empty() && distance(p, road.line.back()) < 0.1) continue;
    road.line.push_back(p);
    road.nodes.push_back(n.id);
  }
  road.ring = isOneOf(way.tags["junction"], {"roundabout", "circular"});
  const std::string& oneWay = way.tags["oneway"];
  road.oneWay = road.ring || isOneOf(oneWay, {"yes", "true", "1", "-1"}) || way.tags["highway"] == "motorway";
  if (oneWay == "-1") {
    std::reverse(road.line.begin(), road.line.end());
    std::reverse(road.nodes.begin(), road.nodes.end());
  }
  road.sidewalk = saidOf(way.tags, {"sidewalk", "sidewalk:both", "sidewalk:left", "sidewalk:right"},
                         {"both", "left", "right", "yes", "separate"}, {"no", "none"});
  road.parking = saidOf(
      way.tags,
      {"parking:both", "parking:left", "parking:right", "parking:lane:both", "parking:lane:left", "parking:lane:right"},
      {"lane", "street_side", "parallel", "yes"}, {"no", "no_parking", "no_stopping"});
  road.width = metresOf(way.tags["width"]);
  if (const auto lanes = metresOf(way.tags["lanes"]); !road.width && lanes) road.width = kLane * *lanes;
  constexpr double kNarrowest = 2, kWidest = 24;  // m; other widths are taken as errors of the map
  if (road.width && (*road.width < kNarrowest || *road.width > kWidest)) road.width.reset();
  return road;
}

// Returns the ring of the nodes in the plane, without points on straight walls. Outer rings stay counter-clockwise and
// inner rings clockwise, even if the plane is mirrored.
Polygon ringOf(const std::vector<OsmNode>& nodes, const TangentPlane& plane) {
  constexpr double kShortest = 0.25;  // m, least length of a wall
  Polygon ring;
  for (const OsmNode& n : nodes) {
    const Point2 p = plane(n);
    if (!ring.empty() && distance(p, ring.back()) < kShortest) continue;
    ring.push_back(p);
  }
  while (ring.size() > 1 && distance(ring.front(), ring.back()) < kShortest) {
    ring.pop_back();
  }
  // Leaves out points on straight walls.
  Polygon corners;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point2& a = corners.empty() ? ring.back() : corners.back();
    const Point2& b = ring[i];
    const Point2& c = ring[(i + 1) % ring.size()];
    const double turn = (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
    if (std::abs(turn) >= 0.05 * std::hypot(c.x - a.x, c.y - a.y)) corners.push_back(b);
  }
  if (plane.mirrored()) std::reverse(corners.begin(), corners.end());
  return corners;
}

std::optional<Land> landOf(const OsmTags& tags) {
  if (isOneOf(tags["landuse"], {"forest", "orchard"}) || isOneOf(tags["natural"], {"wood", "scrub"})) return Land::Wood;
  if (isOneOf(tags["natural"], {"water"}) || isOneOf(tags["landuse"], {"basin", "reservoir"})) return Land::Water;
  if (tags["amenity"] == "parking" && isOneOf(tags["parking"], {"", "surface"})) return Land::Lot;
  if (isOneOf(tags["leisure"], {"park", "garden"}) ||
      isOneOf(tags["landuse"], {"village_green", "recreation_ground", "cemetery"})) {
    return Land::Park;
  }
  if (isOneOf(tags["leisure"], {"pitch", "playground", "golf_course"}) ||
      isOneOf(tags["landuse"], {"grass", "meadow", "farmland"}) || isOneOf(tags["natural"], {"grassland", "heath"})) {
    return Land::Grass;
  }
  // OpenStreetMap represents squares as areas of roads for pedestrians or services, or as marketplaces.
  const bool square = tags["area"] == "yes";
  if ((square && isOneOf(tags["highway"], {"pedestrian", "footway", "service"})) || tags["amenity"] == "marketplace") {
    return Land::Paved;
  }
  return std::nullopt;
}

std::optional<models::Fencing> fencingOf(const std::string& barrier) {
  if (barrier == "hedge") return models::Fencing::Hedge;
  if (isOneOf(barrier, {"wall", "retaining_wall"})) return models::Fencing::Brick;
  if (barrier == "fence") return models::Fencing::Pickets;
  return std::nullopt;
}

std::optional<models::Roof> roofOf(const std::string& shape) {
  static const std::map<std::string_view, models::Roof> kShapes = {
      {"flat", models::Roof::Flat},         {"gabled", models::Roof::Gable},
      {"half-hipped", models::Roof::Gable}, {"cross_gabled", models::Roof::CrossGable},
      {"hipped", models::Roof::Hip},        {"pyramidal", models::Roof::Hip},
  };
  const auto found = kShapes.find(shape);
  return found == kShapes.end() ? std::nullopt : std::optional(found->second);
}

// Returns the usual height (m) of a pitched roof; 0 for flat roofs, and for outlines that are wide or not rectangular.
double usualRise(const Polygon& outline, const std::optional<models::Roof>& roof) {
  constexpr double kSlope = 0.75;
  constexpr double kWidest = 18;  // m, width of the widest building with a pitched roof
  const models::Footprint about = rectangleAbout(outline);
  const double narrow = std::min(about.halfX, about.halfY);
  const bool pitched = roof != models::Roof::Flat && sizeOf(outline) > 0.9 * 4 * about.halfX * about.halfY;
  return pitched && 2 * narrow < kWidest ? kSlope * narrow : 0;
}

MapBuilding buildingOf(const OsmArea& area, const TangentPlane& plane) {
  MapBuilding building;
  building.outline = ringOf(area.outer, plane);
  for (const std::vector<OsmNode>& inner : area.inner) {
    Polygon court = ringOf(inner, plane);
    if (court.size() > 2) building.courts.push_back(std::move(court));
  }
  const OsmTags& tags = area.tags;
  constexpr double kMostFloors = 120;
  if (const auto floors = metresOf(tags["building:levels"]); floors && *floors >= 0.5 && *floors <= kMostFloors) {
    building.floors = static_cast<int>(std::lround(*floors));
  }
  constexpr double kLowest = 2, kHighest = 400;  // m; other heights are taken as errors of the map
  building.top = metresOf(tags["height"]);
  if (building.top && (*building.top < kLowest || *building.top > kHighest)) building.top.reset();
  building.roof = roofOf(tags["roof:shape"]);
  if (building.top) {
    const double rise = metresOf(tags["roof:height"]).value_or(usualRise(building.outline, building.roof));
    building.height = std::max(*building.top - rise, std::min(*building.top, kLowest));
  }
  building.shop = !tags["shop"].empty() || isOneOf(tags["building"], {"retail", "supermarket", "commercial"});
  building.shed = isOneOf(tags["building"],
                          {"garage", "garages", "shed", "hut", "greenhouse", "service", "barn", "farm_auxiliary"});
  return building;
}

}  // namespace

std::optional<int> MapBuilding::floorsSaid() const {
  constexpr double kStorey = 2.9;  // m, usual height of a storey
  constexpr double kLeast = 2.4;
  if (floors && top) return std::min(*floors, std::max(1, static_cast<int>(*top / kLeast)));
  if (floors) return floors;
  return height ? std::optional(std::max(1, static_cast<int>(std::lround(*height / kStorey)))) : std::nullopt;
}

std::optional<double> metresOf(const std::string& value) {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || !std::isfinite(number) || number < 0) return std::nullopt;
  std::string_view unit(end, static_cast<std::size_t>(value.data() + value.size() - end));
  while (unit.starts_with(' ')) unit.remove_prefix(1);
  if (unit.empty() || unit == "m") return number;
  if (unit == "ft" || unit == "'") return 0.3048 * number;
  return std::nullopt;
}

OsmNode degreesAt(const Map& map, const Point2& p) {
  return TangentPlane(map.latitude, map.longitude, map.mirrored).degreesAt(p);
}

Map makeMap(const OsmExtract& extract, bool mirrored) {
  // The origin is the middle of the bounds of all roads.
  double south = 90, north = -90, west = 180, east = -180;
  for (const OsmWay& way : extract.ways) {
    if (!classOf(way.tags)) continue;
    for (const OsmNode& n : way.nodes) {
      south = std::min(south, n.latitude);
      north = std::max(north, n.latitude);
      west = std::min(west, n.longitude);
      east = std::max(east, n.longitude);
    }
  }
  Map map;
  map.latitude = (south + north) / 2;
  map.longitude = (west + east) / 2;
  map.mirrored = mirrored;
  const TangentPlane plane(map.latitude, map.longitude, mirrored);
  std::vector<MapRoad> ways;
  for (const OsmWay& way : extract.ways) {
    if (!onGround(way.tags) || way.tags["area"] == "yes") continue;
    const std::optional<RoadClass> kind = classOf(way.tags);
    if (kind) {
      MapRoad road = roadOf(way, *kind, plane);
      if (road.line.size() > 1) ways.push_back(std::move(road));
      continue;
    }
    std::vector<Point2> line;
    for (const OsmNode& n : way.nodes) line.push_back(plane(n));
    if (line.size() < 2) continue;
    const std::optional<models::Fencing> fencing = fencingOf(way.tags["barrier"]);
    if (fencing) {
      map.barriers.push_back({*fencing, std::move(line)});
    } else if (isPath(way.tags)) {
      map.paths.push_back(std::move(line));
    }
  }
  map.roads = joinRoads(ways);
  for (const OsmArea& area : extract.areas) {
    if (!onGround(area.tags)) continue;
    // Roofs without walls are left out, since they would get walls.
    if (isOneOf(area.tags["building"], {"roof", "carport"})) continue;
    const bool built = !isOneOf(area.tags["building"], {"", "no"});
    if (built) {
      MapBuilding building = buildingOf(area, plane);
      if (building.outline.size() > 2) map.buildings.push_back(std::move(building));
      continue;
    }
    const std::optional<Land> land = landOf(area.tags);
    if (!land) continue;
    MapArea made{*land, ringOf(area.outer, plane), {}};
    if (made.outline.size() < 3) continue;
    for (const std::vector<OsmNode>& inner : area.inner) made.holes.push_back(ringOf(inner, plane));
    map.areas.push_back(std::move(made));
  }
  for (const OsmPoint& point : extract.points) {
    if (point.tags["natural"] == "tree") map.trees.push_back(plane(point.node));
  }
  return map;
}

Map readMap(const std::filesystem::path& file, bool mirrored, const Location& where) {
  // Makes the path absolute: libosmium would download a name that begins like a URL.
  const std::filesystem::path absolute = std::filesystem::absolute(file);
  if (!std::filesystem::is_regular_file(absolute)) {
    throw InputError(where, fmt::format("{} is not a file: a map is an OpenStreetMap extract", file.string()));
  }
  OsmExtract extract;
  try {
    extract = moduleOf<OsmModule>().read(absolute.string());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError(where, fmt::format("{} cannot be read as an OpenStreetMap extract (.osm, .osm.bz2, .osm.gz, "
                                        ".osm.pbf): {}",
                                        file.string(), e.what()));
  }
  Map map = makeMap(extract, mirrored);
  map.file = file;
  if (map.roads.empty()) {
    throw InputError(
        where, fmt::format("{} has no road for cars, such as a way with the tag highway=residential", file.string()));
  }
  return map;
}

}  // namespace scanmill::town
