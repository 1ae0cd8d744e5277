#pragma once

// Reads an OpenStreetMap extract, with the tags of "Simple 3D Buildings", and cuts out a place for a town. Frame: m, x
// east, y north, in the plane that touches the WGS 84 ellipsoid in the middle of the extract's roads.

#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/format_support.h"
#include "models/models.h"
#include "town/geometry.h"
#include "town/osm.h"

namespace scanmill::town {

struct Parameters;

// The classes of roads, from the widest to the narrowest.
enum class RoadClass { Primary, Secondary, Tertiary, Residential, Service, Track };

struct MapRoad {
  std::string name;
  RoadClass kind = RoadClass::Residential;
  std::vector<Point2> line;  // the map's points; corners are not rounded
  // OpenStreetMap's id of each point of `line`. Roads join where they share a node.
  std::vector<std::int64_t> nodes;
  bool oneWay = false;   // true: vehicles drive in only one direction
  bool against = false;  // true: the vehicles of a one-way road drive against the line
  bool ring = false;     // true: the road is a roundabout
  // The next three values are not set if the map does not give them.
  std::optional<double> width;  // m, width of the carriageway without parking lanes
  std::optional<bool> sidewalk;
  std::optional<bool> parking;
  // Set for side roads: where the road starts (m along the main road), and whether it is at the main road's left.
  std::optional<double> joins;
  bool joinsLeft = false;

  double length() const { return lengthOf(line); }
};

// A building, or a part of a building.
struct MapBuilding {
  Polygon outline;
  std::vector<Polygon> courts;       // outlines of the courtyards, clockwise
  double base = 0;                   // m, height of the underside above the ground
  std::optional<double> top;         // m, height of the roof's top above the ground
  std::optional<int> floors;         // number of floors above the ground
  std::optional<models::Roof> roof;  // roof of a house; not set: the map gives no shape that houses can have
  // Ends of the ridge of a pitched roof; equal: a pyramid. Not set: the roof is flat or, for a house, random.
  std::optional<std::array<Point2, 2>> ridge;
  double rise = 0;          // m, height of the roof
  bool riseMapped = false;  // true: the map gives the height of the roof; false: `rise` is a usual height
  bool shop = false;
  bool shed = false;  // true: a garage, shed or similar building without windows
  // If there are parts, only the parts are built, not the outline.
  std::vector<MapBuilding> parts;
  std::int64_t relation = 0;  // see OsmArea::building
  std::string difference;     // how the roof of the town differs from the map's; empty: no difference

  // Returns the height (m) of the top of the walls; nullopt if the map does not give the top of the roof.
  std::optional<double> eaves() const;
  // Returns the number of floors: the map's number, limited to what fits into the height. If the map gives no number,
  // returns the usual number for the height; nullopt if the map gives neither floors nor height.
  std::optional<int> usualFloors() const;
};

enum class Land { Wood, Park, Grass, Water, Lot, Paved };

struct MapArea {
  Land land = Land::Grass;
  Polygon outline;
  std::vector<Polygon> holes;
  bool square = true;  // for paved areas; true: benches and fountains may be placed on the area
};

struct MapBarrier {
  models::Fencing kind = models::Fencing::Pickets;
  std::vector<Point2> line;
  std::optional<double> height;  // m; not set: the map does not give it
};

struct MapPath {
  std::vector<Point2> line;
  std::optional<double> width;  // m; not set: the map does not give it
};

struct MapTree {
  Point2 at;
  std::optional<double> height, crown;  // m, height and diameter of the crown; not set: the map does not give them
};

// The contents of a map, or of a part of it, besides its roads.
struct MapContents {
  std::vector<MapPath> paths;
  std::vector<MapBuilding> buildings;
  std::vector<MapArea> areas;
  std::vector<MapBarrier> barriers;
  std::vector<MapTree> trees;
};

struct Map : MapContents {
  std::filesystem::path file;
  OsmNode origin;              // origin of the map's frame
  bool mirrored = false;       // true: y points south
  std::vector<MapRoad> roads;  // joined by joinRoads()
  LeftOut leftOut;             // features of the map that the town lacks or shows differently
};

// A square cut out of a map. Coordinates (m; x east, y north) are relative to the square's own origin.
struct MapPlace : MapContents {
  OsmNode origin;  // origin of the place's frame, on the main road
  // The main road comes first. Lines are smoothed, with points about kRoadStep apart; `nodes` is empty.
  std::vector<MapRoad> roads;
  std::vector<Point2> joints;         // points where roads meet
  double mainFrom = 0, mainTo = 0;    // m along the main road, the ends of its built-up part
  std::string district = "suburban";  // value of the key `district`
};

// Lists the tags and elements that readMap() reads, and those that readMap() leaves out.
extern const FormatSupport kOsmFormat;

// Returns the latitude and longitude (degrees) of a point in the map's frame.
OsmNode degreesAt(const Map& map, const Point2& p);

// Returns the map in a file; warns of omitted features. Throws InputError at `where` if no roads can be read.
Map readMap(const std::filesystem::path& file, bool mirrored, const Location& where);
// Builds a map from an extract in memory. `mirrored`: y points south.
Map makeMap(const OsmExtract& extract, bool mirrored = false);

// Returns a square of the map, with sides of 2 * reach metres, around a random point of the road that the parameters
// name, or of a random road. Throws an InputError at `where` for an unknown name or if no road is long enough.
MapPlace cutOut(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where);

// Joins roads that meet end to end. At crossings, joins the roads that continue straight ahead.
[[nodiscard]] std::vector<MapRoad> joinRoads(const std::vector<MapRoad>& roads);

// These functions interpret tags of OpenStreetMap. They return nullopt if the tags do not give the property.
std::optional<RoadClass> roadClassOf(const OsmTags& tags);
std::optional<Land> landOf(const OsmTags& tags);
std::optional<models::Fencing> fencingOf(const std::string& barrier);
std::optional<bool> sidewalkOf(const OsmTags& tags);
std::optional<bool> parkingOf(const OsmTags& tags);

bool isPath(const OsmTags& tags);
// True if a path is a road's pavement, which is built as part of the road.
bool isSidewalk(const OsmTags& tags);
// True if an object is on the ground. Other objects, such as tunnels and bridges, are left out.
bool onGround(const OsmTags& tags);
// True if the map says that an object does not exist yet or no longer exists.
bool isAbsent(const OsmTags& tags);
// True if the tag `surface` is missing or has one of `values`.
bool hasSurface(const OsmTags& tags, std::initializer_list<std::string_view> values);
// True if an element has the key highway and is tagged as an area, even if its outline is not closed.
bool isHighwayArea(const OsmTags& tags);
// True for a roof without walls. Towns leave such a roof out. False for parts with a min_height.
bool isOpenRoof(const OsmTags& tags);
// True if the map gives a building's material or colour, or says that it is a ruin, abandoned or being built.
bool hasLook(const OsmTags& tags);
// True if a road has features that a town's road cannot have, such as cycleways, or a sidewalk on only one side.
bool differsFromTownRoads(const OsmTags& tags);

// Returns the first tag of an object with a shape on the ground, such as "highway=street_lamp"; empty if there is none.
std::string shapeTagOf(const OsmTags& tags);

// Returns the building, or part of a building, with these tags. `mirrored`: y points south.
MapBuilding makeBuilding(const OsmTags& tags, Polygon outline, std::vector<Polygon> courts, bool mirrored,
                         TagNumbers& numbers);

// True if the outline covers more than 90 % of the rectangle `about`, or 98 % if it does not have four corners.
bool isRectangular(const Polygon& outline, const models::Footprint& about);

// Moves each part into its building, found by relation or position; a part outside of all buildings becomes a building.
// If the parts of a building do not cover its outline, adds the uncovered regions as further parts. Removes buildings
// and parts without a height. Counts in `leftOut` those removed and those that will differ from the map.
void joinParts(std::vector<MapBuilding>& buildings, std::vector<MapBuilding> parts, LeftOut& leftOut);

}  // namespace scanmill::town
