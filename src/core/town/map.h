#pragma once

// A place on an OpenStreetMap extract. A town can be laid out from it instead of at random. Frame: metres, x east, y
// north, in the plane that touches the WGS 84 ellipsoid in the middle of the extract's roads.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "models/models.h"
#include "town/geometry.h"
#include "town/osm.h"

namespace scanmill::town {

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

  double length() const { return lengthOf(line); }
};

struct MapBuilding {
  Polygon outline;
  std::vector<Polygon> courts;       // outlines of the courtyards, clockwise
  std::optional<double> top;         // m, top of the roof
  std::optional<double> height;      // m, height of the eaves
  std::optional<int> floors;         // number of floors above the ground
  std::optional<models::Roof> roof;  // not set: the map gives no shape, or a shape that houses do not have
  bool shop = false;
  bool shed = false;  // true: a garage, shed or similar building without windows

  // Returns the number of floors: the map's number, limited to what fits into the height. If the map gives no number,
  // returns the usual number for the height; nullopt if the map gives neither floors nor height.
  std::optional<int> floorsSaid() const;
};

enum class Land { Wood, Park, Grass, Water, Lot, Paved };

struct MapArea {
  Land land = Land::Grass;
  Polygon outline;
  std::vector<Polygon> holes;
};

struct MapBarrier {
  models::Fencing kind = models::Fencing::Pickets;
  std::vector<Point2> line;
};

struct Map {
  std::filesystem::path file;
  double latitude = 0, longitude = 0;  // degrees; position of the frame's origin
  bool mirrored = false;               // true: y points south
  std::vector<MapRoad> roads;          // joined by joinRoads()
  std::vector<std::vector<Point2>> paths;
  std::vector<MapBuilding> buildings;
  std::vector<MapArea> areas;
  std::vector<MapBarrier> barriers;
  std::vector<Point2> trees;
};

// Returns the latitude and longitude (degrees) of a point in the map's frame.
OsmNode degreesAt(const Map& map, const Point2& p);

// Reads an extract. Throws an InputError at `where`, with the file's name, if the file cannot be read or has no road
// for cars.
Map readMap(const std::filesystem::path& file, bool mirrored, const Location& where);
// Builds a map from an extract in memory.
Map makeMap(const OsmExtract& extract, bool mirrored = false);

// Joins roads that meet end to end. At crossings, joins the roads that continue straight ahead.
[[nodiscard]] std::vector<MapRoad> joinRoads(const std::vector<MapRoad>& roads);

// Returns the length (m) that a tag's value such as "12", "12.5 m" or "40'" gives; nullopt for other values.
std::optional<double> metresOf(const std::string& value);

}  // namespace scanmill::town
