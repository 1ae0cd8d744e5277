#include "town/map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "base/earth.h"
#include "base/input_budget.h"
#include "base/text_scan.h"
#include "config/text.h"

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

MapRoad roadOf(const OsmTags& tags, const std::vector<OsmNode>& nodes, RoadClass kind, const TangentPlane& plane,
               TagNumbers& numbers) {
  constexpr double kLane = 3.1;                   // m, width of a lane if the map gives only the number of lanes
  constexpr double kNarrowest = 2, kWidest = 24;  // m; other widths are taken as errors of the map
  MapRoad road;
  road.kind = kind;
  road.name = tags["name"];
  for (const OsmNode& n : nodes) {
    const Point2 p = plane(n);
    if (!road.line.empty() && distance(p, road.line.back()) < 0.1) continue;
    road.line.push_back(p);
    road.nodes.push_back(n.id);
  }
  road.ring = isOneOf(tags["junction"], {"roundabout", "circular"});
  const std::string& oneWay = tags["oneway"];
  road.oneWay =
      road.ring || isOneOf(oneWay, {"yes", "true", "1", "-1"}) || (tags["highway"] == "motorway" && oneWay != "no");
  if (oneWay == "-1") {
    std::reverse(road.line.begin(), road.line.end());
    std::reverse(road.nodes.begin(), road.nodes.end());
  }
  road.sidewalk = sidewalkOf(tags);
  road.parking = parkingOf(tags);
  const char* const width = tags["width"].empty() ? "est_width" : "width";
  road.width = numbers.read(tags, width, metresOf, kNarrowest, kWidest);
  if (const auto lanes = numbers.read(tags, "lanes", numberOf, 1, kWidest / kLane); lanes && !road.width) {
    road.width = kLane * *lanes;
  }
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

// Returns the plane that touches the earth in the middle of the bounds of all roads.
TangentPlane planeAbout(const OsmExtract& extract, bool mirrored, Map& map) {
  double south = 90, north = -90, west = 180, east = -180;
  for (const OsmWay& way : extract.ways) {
    if (!roadClassOf(way.tags)) continue;
    for (const std::vector<OsmNode>& nodes : way.runs) {
      for (const OsmNode& n : nodes) {
        south = std::min(south, n.latitude);
        north = std::max(north, n.latitude);
        west = std::min(west, n.longitude);
        east = std::max(east, n.longitude);
      }
    }
  }
  map.latitude = (south + north) / 2;
  map.longitude = (west + east) / 2;
  map.mirrored = mirrored;
  return {map.latitude, map.longitude, mirrored};
}

// Makes a map from an extract, and counts what it leaves out.
class MapMaker {
 public:
  MapMaker(const OsmExtract& extract, bool mirrored) : extract_(extract), plane_(planeAbout(extract, mirrored, map_)) {}

  Map make() {
    for (const auto& [what, count] : extract_.leftOut) map_.leftOut.add(what, count);
    for (const OsmWay& way : extract_.ways) addWay(way);
    map_.roads = joinRoads(roads_);
    for (const OsmArea& area : extract_.areas) addArea(area);
    joinParts(map_.buildings, std::move(parts_), map_.leftOut);
    for (const OsmPoint& point : extract_.points) addPoint(point);
    numbers_.tell(map_.leftOut);
    return std::move(map_);
  }

 private:
  void addWay(const OsmWay& way) {
    const OsmTags& tags = way.tags;
    if (isAbsent(tags) || (isHighwayArea(tags) && way.area)) return;
    const std::optional<RoadClass> kind = roadClassOf(tags);
    const std::optional<models::Fencing> fencing = fencingOf(tags["barrier"]);
    if (!kind && !fencing && isPath(tags) && isSidewalk(tags)) return;
    const char* const what = kind ? "roads" : fencing ? "fences, hedges and walls" : isPath(tags) ? "paths" : nullptr;
    if (what == nullptr) return leaveOut(tags);
    if (!onGround(tags)) return map_.leftOut.add(fmt::format("{} {}", what, kOffGround));
    if (const std::string& railway = tags["railway"]; !railway.empty()) {
      leaveOut({tags.element, {{"railway", railway}}});
    }
    if ((kind || !fencing) && !hasSurface(tags, {"asphalt", "paved", "concrete"})) map_.leftOut.add(kSurfaces);
    if (way.incomplete) map_.leftOut.add(fmt::format("{} with missing nodes, which are built in part", what));
    if (kind && differsFromTownRoads(tags)) {
      map_.leftOut.add("roads with sidewalks, parking, cycleways or embankments that differ from the town's");
    }
    if (kind && tags["driving_side"] == (plane_.mirrored() ? "right" : "left")) {
      map_.leftOut.add("roads on which traffic keeps to the other side than in the town");
    }
    if (!kind && fencing && way.area && tags["area"] == "yes") map_.leftOut.add(kHollow);
    for (const std::vector<OsmNode>& nodes : way.runs) {
      if (kind) {
        MapRoad road = roadOf(tags, nodes, *kind, plane_, numbers_);
        if (road.line.size() > 1) roads_.push_back(std::move(road));
        continue;
      }
      std::vector<Point2> line;
      for (const OsmNode& n : nodes) line.push_back(plane_(n));
      if (line.size() < 2) continue;
      if (fencing) {
        map_.barriers.push_back({*fencing, std::move(line), numbers_.read(tags, "height", metresOf, 0.1, 50)});
      } else {
        map_.paths.push_back({std::move(line), numbers_.read(tags, "width", metresOf, 0.3, 24)});
      }
    }
  }

  void addArea(const OsmArea& area) {
    const OsmTags& tags = area.tags;
    if (isAbsent(tags)) return;
    const std::optional<Land> land = landOf(tags);
    const bool building = !isOneOf(tags["building"], {"", "no"});
    const bool part = !building && !isOneOf(tags["building:part"], {"", "no"});
    if (!building && !part && !land) {
      // addWay() has counted ways with one of these keys.
      if (isHighwayArea(tags) || tags.element.starts_with("relation") ||
          (tags["highway"].empty() && tags["barrier"].empty())) {
        leaveOut(tags);
      }
      return;
    }
    const char* const what = building ? "buildings" : part ? "building parts" : "areas of land";
    Polygon outline = ringOf(area.outer, plane_);
    if (!area.fault.empty()) return map_.leftOut.add(fmt::format("{} with {}", what, area.fault));
    if (!onGround(tags)) return map_.leftOut.add(fmt::format("{} {}", what, kOffGround));
    if (isOpenRoof(tags)) return map_.leftOut.add("open roofs and carports");
    if (outline.size() < 3) return map_.leftOut.add(fmt::format("{} that have less than three corners", what));
    std::vector<Polygon> holes;
    for (const std::vector<OsmNode>& inner : area.inner) {
      Polygon hole = ringOf(inner, plane_);
      if (hole.size() > 2) holes.push_back(std::move(hole));
    }
    if (!building && !part) return addLand(*land, tags, std::move(outline), std::move(holes));
    if (hasLook(tags)) {
      map_.leftOut.add("buildings with materials, colours or a state, such as ruins, which the seed draws as if whole");
    }
    MapBuilding made = makeBuilding(tags, std::move(outline), std::move(holes), plane_.mirrored(), numbers_);
    made.relation = area.building;
    (part ? parts_ : map_.buildings).push_back(std::move(made));
  }

  void addLand(Land land, const OsmTags& tags, Polygon outline, std::vector<Polygon> holes) {
    const bool hard = land == Land::Lot || land == Land::Paved;
    if (hard && !hasSurface(tags, {"asphalt", "paved", "concrete", "paving_stones"})) map_.leftOut.add(kSurfaces);
    if (tags.element.starts_with("relation") && !tags["barrier"].empty()) {
      leaveOut({tags.element, {{"barrier", tags["barrier"]}}});
    }
    const bool square =
        isOneOf(tags["highway"], {"pedestrian", "footway", "service"}) || tags["amenity"] == "marketplace";
    map_.areas.push_back({land, std::move(outline), std::move(holes), square});
  }

  void addPoint(const OsmPoint& point) {
    if (!point.tags["ele"].empty()) map_.leftOut.add("heights of nodes (ele)");
    if (isAbsent(point.tags)) return;
    if (point.tags["natural"] == "tree") {
      map_.trees.push_back({plane_(point.node), numbers_.read(point.tags, "height", metresOf, 0.5, 130),
                            numbers_.read(point.tags, "diameter_crown", metresOf, 0.3, 60)});
    } else if (!isOneOf(point.tags["building"], {"", "no", "entrance"})) {
      map_.leftOut.add("buildings that are nodes");
    } else if (point.tags["highway"] == "crossing" &&
               isOneOf(point.tags["crossing"], {"marked", "zebra", "uncontrolled", "traffic_signals"})) {
      map_.leftOut.add("marked crossings, which the seed draws");
    } else {
      leaveOut(point.tags);
    }
  }

  // Counts an element that is not built by its first tag that stands for a shape.
  void leaveOut(const OsmTags& tags) {
    if (const std::string tag = shapeTagOf(tags); !tag.empty()) map_.leftOut.add(tag);
  }

  static constexpr const char* kHollow =
      "hedges, walls and fences that are areas, of which only the outlines are built";
  static constexpr const char* kSurfaces =
      "surfaces of roads, paths and paved areas, such as gravel, which are built of asphalt, concrete or paving";
  static constexpr const char* kOffGround = "on bridges, in tunnels, indoors or underground";

  const OsmExtract& extract_;
  Map map_;
  TangentPlane plane_;
  TagNumbers numbers_;
  std::vector<MapRoad> roads_;
  std::vector<MapBuilding> parts_;
};

// Throws InputError if a square of 100 m holds more than 10 km of roads: the ground beside a road takes a time that
// grows with the roads near it, and car parks of five floors have about 3 km.
void checkDensity(const Map& map) {
  constexpr double kCell = 100;     // m
  constexpr double kMost = 10'000;  // m
  const Location where{map.file.string()};
  std::map<std::pair<double, double>, double> lengths;
  for (const MapRoad& road : map.roads) {
    for (std::size_t i = 1; i < road.line.size(); ++i) {
      const Point2 &a = road.line[i - 1], &b = road.line[i];
      const double length = std::hypot(b.x - a.x, b.y - a.y);
      const auto pieces = static_cast<int>(std::ceil(length / kCell));
      for (int k = 0; k < pieces; ++k) {
        chargeTime(where);
        const double share = (k + 0.5) / pieces;
        const Point2 at{a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share};
        double& sum = lengths[{std::floor(at.x / kCell), std::floor(at.y / kCell)}];
        sum += length / pieces;
        if (sum <= kMost) continue;
        const OsmNode place = degreesAt(map, at);
        throw InputError(
            where, fmt::format("has more than {:.0f} km of roads in a square of {:.0f} m, about latitude {:.6f} and "
                               "longitude {:.6f}: remove roads that are there several times",
                               kMost / 1000, kCell, place.latitude, place.longitude));
      }
    }
  }
}

// True if the editor JOSM has marked an object of a file as deleted, which libosmium does not tell.
bool hasDeletions(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  while (lowerExtension(file) == ".osm" && std::getline(in, line)) {
    if (line.find("action='delete'") != line.npos || line.find("action=\"delete\"") != line.npos) return true;
  }
  return false;
}

}  // namespace

const FormatSupport& osmFormat() {
  static const FormatSupport format{
      "OpenStreetMap",
      ".osm, .osm.gz, .osm.bz2, .osm.pbf, .o5m, .opl",
      {},
      "Nodes, ways and relations in this order, each by their ids. Roads, paths, buildings with their parts and roofs, "
      "barriers, trees, woods, water, parks, lawns, squares and parking lots, with the tags that town.md names; "
      "multipolygons, boundaries and relations of buildings; lengths in metres unless they have another unit",
      "all else that has a shape, by its tag, such as highway=street_lamp; what is on bridges, in tunnels, indoors or "
      "underground; surfaces of roads, looks and states of buildings, heights of nodes; buildings that are nodes; "
      "buildings, roads and areas with missing nodes; pitched roofs over outlines that are no rectangles; areas of "
      "hedges, walls and fences, whose outlines are built; heights and roofs of outer ways that differ from those of "
      "their multipolygon; holes of multipolygons without tags; values that are no numbers"};
  return format;
}

OsmNode degreesAt(const Map& map, const Point2& p) {
  return TangentPlane(map.latitude, map.longitude, map.mirrored).degreesAt(p);
}

Map makeMap(const OsmExtract& extract, bool mirrored) {
  return MapMaker(extract, mirrored).make();
}

Map readMap(const std::filesystem::path& file, bool mirrored, const Location& where) {
  // Makes the path absolute: libosmium would download a name that begins like a URL.
  const std::filesystem::path absolute = std::filesystem::absolute(file);
  if (!std::filesystem::is_regular_file(absolute)) {
    throw InputError(where, fmt::format("{} is not a file: a map is an OpenStreetMap extract", file.string()));
  }
  chargeFile(absolute);
  if (hasDeletions(absolute)) {
    throw InputError(where, fmt::format("{} has objects that JOSM marks as deleted: upload the changes or purge these "
                                        "objects (Edit, Purge), and save it again",
                                        file.string()));
  }
  OsmExtract extract;
  try {
    extract = moduleOf<OsmModule>().read(absolute.string());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError(where, fmt::format("{} cannot be read as an OpenStreetMap extract ({}): {}; the Overpass API "
                                        "writes such files with `[out:xml]` and `(._;>;); out meta;`, and `osmium cat "
                                        "-o place.osm.pbf` rewrites files with another compression",
                                        file.string(), osmFormat().suffixes, reasonOf(e)));
  }
  Map map = makeMap(extract, mirrored);
  map.file = file;
  if (map.roads.empty()) {
    throw InputError(where, fmt::format("{} has no road for cars, such as a way with the tag highway=residential{}{}",
                                        file.string(), map.leftOut.empty() ? "" : "; left out: ", map.leftOut.text()));
  }
  checkDensity(map);
  map.leftOut.warn(file.string());
  double reach = 0;
  for (const MapRoad& road : map.roads) reach = std::max(reach, std::hypot(road.line[0].x, road.line[0].y));
  constexpr double kFarthest = 5e5;  // m; lengths there are 0.3 % too short
  if (reach > kFarthest) {
    warn(
        fmt::format("{}: roads are up to {:.0f} km from their middle, where lengths are too short in the plane of the "
                    "scene: cut a district out, for example with `osmium extract`",
                    file.string(), reach / 1000));
  }
  return map;
}

}  // namespace scanmill::town
