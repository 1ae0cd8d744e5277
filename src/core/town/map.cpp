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

// The plane that touches the WGS 84 ellipsoid at `origin`. Coordinates are metres from the origin: x east, y north
// (south if mirrored). Points of the ellipsoid are projected onto the plane: 25 km away, distances are 0.1 m too short.
class TangentPlane {
 public:
  TangentPlane(const OsmNode& origin, bool mirrored)
      : latitude_(radians(origin.latitude)),
        longitude_(radians(origin.longitude)),
        north_(mirrored ? -1 : 1),
        origin_(earthCentred(longitude_, latitude_, 0)) {}

  Point2 operator()(const OsmNode& n) const {
    const Vec3d d = earthCentred(radians(n.longitude), radians(n.latitude), 0) - origin_;
    const double outwards = d.x * std::cos(longitude_) + d.y * std::sin(longitude_);  // m from the earth's axis
    return {d.y * std::cos(longitude_) - d.x * std::sin(longitude_),
            north_ * (d.z * std::cos(latitude_) - outwards * std::sin(latitude_))};
  }
  bool mirrored() const { return north_ < 0; }

  // Returns the latitude and longitude (degrees) of a point in the plane: the inverse of operator(). Uses Newton's
  // method with a constant derivative, the number of degrees per metre to the north and to the east at the origin.
  OsmNode degreesAt(const Point2& p) const {
    constexpr double kDegree = 111300;  // m, length of a degree of latitude
    constexpr int kIterations = 12;
    OsmNode node{0, degrees(latitude_), degrees(longitude_)};
    for (int i = 0; i < kIterations; ++i) {
      const Point2 estimate = (*this)(node);
      node.latitude += north_ * (p.y - estimate.y) / kDegree;
      node.longitude += (p.x - estimate.x) / (kDegree * std::max(0.01, std::cos(latitude_)));
    }
    return node;
  }

 private:
  double latitude_, longitude_;  // rad
  double north_;                 // 1: y points north; -1: y points south (mirrored)
  Vec3d origin_;
};

// Returns a road with the properties that the tags give. The line of a one-way road goes in the direction of driving.
MapRoad roadOf(const OsmTags& tags, const std::vector<OsmNode>& nodes, RoadClass kind, const TangentPlane& plane,
               TagNumbers& numbers) {
  constexpr double kLane = 3.1;                   // m, width of a lane if the map gives only the number of lanes
  constexpr double kNarrowest = 2, kWidest = 24;  // m; widths outside are taken as errors of the map
  constexpr double kLeastDistance = 0.1;          // m between two points of the line
  MapRoad road;
  road.kind = kind;
  road.name = tags["name"];
  for (const OsmNode& n : nodes) {
    const Point2 p = plane(n);
    if (!road.line.empty() && distance(p, road.line.back()) < kLeastDistance) continue;
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

// Returns the ring of the nodes without points on straight walls. A mirrored ring stays clockwise or counter-clockwise.
Polygon ringOf(const std::vector<OsmNode>& nodes, const TangentPlane& plane) {
  constexpr double kShortest = 0.25;     // m, least length of a wall
  constexpr double kLeastOffset = 0.05;  // m between a corner and the straight line through its neighbours
  Polygon ring;
  for (const OsmNode& n : nodes) {
    const Point2 p = plane(n);
    if (!ring.empty() && distance(p, ring.back()) < kShortest) continue;
    ring.push_back(p);
  }
  while (ring.size() > 1 && distance(ring.front(), ring.back()) < kShortest) ring.pop_back();
  Polygon corners;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point2& a = corners.empty() ? ring.back() : corners.back();
    const Point2& b = ring[i];
    const Point2& c = ring[(i + 1) % ring.size()];
    // |product| is the distance of b from the line through a and c, multiplied by the distance between a and c.
    const double product = (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
    if (std::abs(product) >= kLeastOffset * std::hypot(c.x - a.x, c.y - a.y)) corners.push_back(b);
  }
  if (plane.mirrored()) std::reverse(corners.begin(), corners.end());
  return corners;
}

// Returns the centre of the bounding box of all roads.
OsmNode middleOfRoads(const OsmExtract& extract) {
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
  return {0, (south + north) / 2, (west + east) / 2};
}

// Makes a map from an extract, and counts the elements and properties that the town lacks.
class MapMaker {
 public:
  MapMaker(const OsmExtract& extract, bool mirrored)
      : extract_(extract), origin_(middleOfRoads(extract)), plane_(origin_, mirrored) {}

  Map make() {
    map_.origin = origin_;
    map_.mirrored = plane_.mirrored();
    for (const auto& [element, count] : extract_.leftOut) map_.leftOut.add(element, count);
    for (const OsmWay& way : extract_.ways) addWay(way);
    map_.roads = joinRoads(roads_);
    for (const OsmArea& area : extract_.areas) addArea(area);
    joinParts(map_.buildings, std::move(parts_), map_.leftOut);
    for (const OsmPoint& point : extract_.points) addPoint(point);
    numbers_.report(map_.leftOut);
    return std::move(map_);
  }

 private:
  // Adds a way as a road, else as a barrier, else as a path. Counts ways and properties of the way that are left out.
  void addWay(const OsmWay& way) {
    const OsmTags& tags = way.tags;
    if (isAbsent(tags) || (isHighwayArea(tags) && way.area)) return;
    const std::optional<RoadClass> road = roadClassOf(tags);
    const std::optional<models::Fencing> barrier = fencingOf(tags["barrier"]);
    if (!road && !barrier && isPath(tags) && isSidewalk(tags)) return;
    if (!road && !barrier && !isPath(tags)) return leaveOut(tags);
    const char* const elements = road ? "roads" : barrier ? "fences, hedges and walls" : "paths";
    if (!onGround(tags)) return map_.leftOut.add(fmt::format("{} {}", elements, kOffGround));
    if (const std::string& railway = tags["railway"]; !railway.empty()) {
      leaveOut({tags.element, {{"railway", railway}}});
    }
    if ((road || !barrier) && !hasSurface(tags, {"asphalt", "paved", "concrete"})) map_.leftOut.add(kSurfaces);
    if (way.incomplete) map_.leftOut.add(fmt::format("{} with missing nodes, which are built in part", elements));
    if (road) {
      addRoad(way, *road);
    } else if (barrier) {
      if (way.area && tags["area"] == "yes") map_.leftOut.add(kHollow);
      for (std::vector<Point2>& line : linesOf(way)) {
        map_.barriers.push_back({*barrier, std::move(line), numbers_.read(tags, "height", metresOf, 0.1, 50)});
      }
    } else {
      for (std::vector<Point2>& line : linesOf(way)) {
        map_.paths.push_back({std::move(line), numbers_.read(tags, "width", metresOf, 0.3, 24)});
      }
    }
  }

  void addRoad(const OsmWay& way, RoadClass kind) {
    if (differsFromTownRoads(way.tags)) {
      map_.leftOut.add("roads with sidewalks, parking, cycleways or embankments that differ from the town's");
    }
    if (way.tags["driving_side"] == (plane_.mirrored() ? "right" : "left")) {
      map_.leftOut.add("roads on which traffic keeps to the other side than in the town");
    }
    for (const std::vector<OsmNode>& nodes : way.runs) {
      MapRoad road = roadOf(way.tags, nodes, kind, plane_, numbers_);
      if (road.line.size() > 1) roads_.push_back(std::move(road));
    }
  }

  // Returns a way's runs of at least two points, in coordinates of the plane.
  std::vector<std::vector<Point2>> linesOf(const OsmWay& way) const {
    std::vector<std::vector<Point2>> lines;
    for (const std::vector<OsmNode>& nodes : way.runs) {
      if (nodes.size() < 2) continue;
      std::vector<Point2>& line = lines.emplace_back();
      for (const OsmNode& n : nodes) line.push_back(plane_(n));
    }
    return lines;
  }

  // Adds a building, building part or land. Counts as left out: damaged areas, open roofs, and areas off the ground.
  void addArea(const OsmArea& area) {
    const OsmTags& tags = area.tags;
    if (isAbsent(tags)) return;
    const std::optional<Land> land = landOf(tags);
    const bool building = !isOneOf(tags["building"], {"", "no"});
    const bool part = !building && !isOneOf(tags["building:part"], {"", "no"});
    if (!building && !part && !land) return leaveOutArea(tags);
    const char* const elements = building ? "buildings" : part ? "building parts" : "areas of land";
    Polygon outline = ringOf(area.outer, plane_);
    if (!area.fault.empty()) return map_.leftOut.add(fmt::format("{} with {}", elements, area.fault));
    if (!onGround(tags)) return map_.leftOut.add(fmt::format("{} {}", elements, kOffGround));
    if (isOpenRoof(tags)) return map_.leftOut.add("open roofs and carports");
    if (outline.size() < 3) return map_.leftOut.add(fmt::format("{} that have less than three corners", elements));
    std::vector<Polygon> holes;
    for (const std::vector<OsmNode>& inner : area.inner) holes.push_back(ringOf(inner, plane_));
    std::erase_if(holes, [](const Polygon& hole) { return hole.size() < 3; });
    if (!building && !part) return addLand(*land, tags, std::move(outline), std::move(holes));
    if (hasLook(tags)) {
      map_.leftOut.add("buildings with materials, colours or a state, such as ruins, which the seed draws as if whole");
    }
    std::vector<MapBuilding>& list = part ? parts_ : map_.buildings;
    list.push_back(makeBuilding(tags, std::move(outline), std::move(holes), plane_.mirrored(), numbers_));
    list.back().relation = area.building;
  }

  // Counts an area that is neither building nor land as left out, unless addWay() handles it as a highway or barrier.
  void leaveOutArea(const OsmTags& tags) {
    const bool countedAsWay = !isHighwayArea(tags) && !tags.element.starts_with("relation") &&
                              (!tags["highway"].empty() || !tags["barrier"].empty());
    if (!countedAsWay) leaveOut(tags);
  }

  // Adds an area of land. Counts its surface and its barrier as left out if the town cannot have them.
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

  // Adds a node that is a tree. Counts another node as left out if its tags say that it is an object with a shape.
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

  // Counts an element as left out, under the tag that shapeTagOf() returns. Without such a tag, does nothing.
  void leaveOut(const OsmTags& tags) {
    if (const std::string tag = shapeTagOf(tags); !tag.empty()) map_.leftOut.add(tag);
  }

  static constexpr const char* kHollow =
      "hedges, walls and fences that are areas, of which only the outlines are built";
  static constexpr const char* kSurfaces =
      "surfaces of roads, paths and paved areas, such as gravel, which are built of asphalt, concrete or paving";
  static constexpr const char* kOffGround = "on bridges, in tunnels, indoors or underground";

  const OsmExtract& extract_;
  OsmNode origin_;
  TangentPlane plane_;
  Map map_;
  TagNumbers numbers_;
  std::vector<MapRoad> roads_;
  std::vector<MapBuilding> parts_;
};

// Throws InputError if a square of 100 m holds more than 10 km of roads: the time to build the ground beside a road
// grows with the number of roads near it. Car parks of five floors have about 3 km of roads.
void checkDensity(const Map& map) {
  constexpr double kCell = 100;        // m, side of a square
  constexpr double kLongest = 10'000;  // m
  const Location where{map.file.string()};
  std::map<std::pair<double, double>, double> lengths;  // m of road, by column and row of a square
  for (const MapRoad& road : map.roads) {
    for (std::size_t i = 1; i < road.line.size(); ++i) {
      const Point2 &a = road.line[i - 1], &b = road.line[i];
      const double length = distance(a, b);
      const auto pieces = static_cast<int>(std::ceil(length / kCell));
      for (int k = 0; k < pieces; ++k) {
        chargeTime(where);
        const Point2 middle = models::lerp(a, b, (k + 0.5) / pieces);
        double& sum = lengths[{std::floor(middle.x / kCell), std::floor(middle.y / kCell)}];
        sum += length / pieces;
        if (sum <= kLongest) continue;
        const OsmNode place = degreesAt(map, middle);
        throw InputError(where,
                         "has more than {:.0f} km of roads in a square of {:.0f} m, about latitude {:.6f} and "
                         "longitude {:.6f}: remove roads that are there several times",
                         kLongest / 1000, kCell, place.latitude, place.longitude);
      }
    }
  }
}

// True if the editor JOSM has marked an element of the file as deleted, which libosmium does not report.
bool hasDeletions(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  while (lowerExtension(file) == ".osm" && std::getline(in, line)) {
    if (line.find("action='delete'") != line.npos || line.find("action=\"delete\"") != line.npos) return true;
  }
  return false;
}

}  // namespace

const FormatSupport kOsmFormat{
    "OpenStreetMap", ".osm, .osm.gz, .osm.bz2, .osm.pbf, .o5m, .opl",
    "Nodes, ways and relations in this order, each by their ids. Roads, paths, buildings with their parts and roofs, "
    "barriers, trees, woods, water, parks, lawns, squares and parking lots, with the tags that town.md names; "
    "multipolygons, boundaries and relations of buildings; lengths in metres unless they have another unit",
    "all else that has a shape, by its tag, such as highway=street_lamp; what is on bridges, in tunnels, indoors or "
    "underground; surfaces of roads, looks and states of buildings, heights of nodes; buildings that are nodes; "
    "buildings, roads and areas with missing nodes; pitched roofs over outlines that are no rectangles; areas of "
    "hedges, walls and fences, whose outlines are built; heights and roofs of outer ways that differ from those of "
    "their multipolygon; holes of multipolygons without tags; values that are no numbers"};

OsmNode degreesAt(const Map& map, const Point2& p) {
  return TangentPlane(map.origin, map.mirrored).degreesAt(p);
}

Map makeMap(const OsmExtract& extract, bool mirrored) {
  return MapMaker(extract, mirrored).make();
}

Map readMap(const std::filesystem::path& file, bool mirrored, const Location& where) {
  // The path is made absolute, since libosmium would download a file whose name begins like a URL.
  const std::filesystem::path absolute = std::filesystem::absolute(file);
  if (!std::filesystem::is_regular_file(absolute)) {
    throw InputError(where, "{} is not a file: a map is an OpenStreetMap extract", file.string());
  }
  chargeFile(absolute);
  if (hasDeletions(absolute)) {
    throw InputError(where,
                     "{} has objects that JOSM marks as deleted: upload the changes or purge these "
                     "objects (Edit, Purge), and save it again",
                     file.string());
  }
  OsmExtract extract;
  try {
    extract = moduleOf<OsmModule>().read(absolute.string());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError(where,
                     "{} cannot be read as an OpenStreetMap extract ({}): {}; the Overpass API "
                     "writes such files with `[out:xml]` and `(._;>;); out meta;`, and `osmium cat "
                     "-o place.osm.pbf` rewrites files with another compression",
                     file.string(), kOsmFormat.suffixes, reasonOf(e));
  }
  Map map = makeMap(extract, mirrored);
  map.file = file;
  if (map.roads.empty()) {
    throw InputError(where, "{} has no road for cars, such as a way with the tag highway=residential{}{}",
                     file.string(), map.leftOut.empty() ? "" : "; left out: ", map.leftOut.text());
  }
  checkDensity(map);
  map.leftOut.warn(file.string());
  double farthest = 0;  // m, largest distance of a road from the origin
  for (const MapRoad& road : map.roads) farthest = std::max(farthest, std::hypot(road.line[0].x, road.line[0].y));
  constexpr double kFarthest = 5e5;  // m; at this distance lengths are 0.3 % too short
  if (farthest > kFarthest) {
    warn(
        "{}: roads are up to {:.0f} km from their middle, where lengths are too short in the plane of the "
        "scene: cut a district out, for example with `osmium extract`",
        file.string(), farthest / 1000);
  }
  return map;
}

}  // namespace scanmill::town
