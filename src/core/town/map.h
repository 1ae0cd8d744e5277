#pragma once

// A place as an OpenStreetMap extract shows it: what a town is laid out from in place of chance. Frame: metres, x east,
// y north, in the plane that touches the WGS 84 ellipsoid in the middle of the extract's roads.

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

// From the widest to the narrowest.
enum class RoadClass { Primary, Secondary, Tertiary, Residential, Service, Track };

struct MapRoad {
  std::string name;
  RoadClass kind = RoadClass::Residential;
  std::vector<Point2> line;  // as it is drawn: corners, not rounded
  // By the OpenStreetMap id of each of its points: roads meet where they share a node.
  std::vector<std::int64_t> nodes;
  bool oneWay = false;   // along the line, or
  bool against = false;  // against it
  bool ring = false;     // a roundabout
  // As far as the map says so (m).
  std::optional<double> width;  // of the carriageway without parking lanes
  std::optional<bool> sidewalk;
  std::optional<bool> parking;

  double length() const { return lengthOf(line); }
};

struct MapBuilding {
  Polygon outline;
  std::vector<Polygon> courts;       // clockwise
  std::optional<double> top;         // m, of the roof
  std::optional<double> height;      // m, to the eaves
  std::optional<int> floors;         // above the ground
  std::optional<models::Roof> roof;  // as far as the map says so, of those that there are
  bool shop = false;
  bool shed = false;  // a garage, shed or the like: without windows

  // By the floors that the map counts, as far as the height has room for them, else by the height.
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
  double latitude = 0, longitude = 0;  // degrees, of the frame's origin
  bool mirrored = false;               // y is south
  std::vector<MapRoad> roads;          // each as long as it goes straight on
  std::vector<std::vector<Point2>> paths;
  std::vector<MapBuilding> buildings;
  std::vector<MapArea> areas;
  std::vector<MapBarrier> barriers;
  std::vector<Point2> trees;
};

// Of a point of the map's frame (degrees).
OsmNode degreesAt(const Map& map, const Point2& p);

// Throws an InputError at `where` with the file where it cannot be read or has no road that cars may drive on.
Map readMap(const std::filesystem::path& file, bool mirrored, const Location& where);
// Of what has been read.
Map makeMap(const OsmExtract& extract, bool mirrored = false);

// Joins roads that meet end to end, and at crossings those that go on straight ahead.
std::vector<MapRoad> joinRoads(const std::vector<MapRoad>& roads);

// A number at the start of a tag's value, in metres: "12", "12.5 m", "40'"; none where it is something else.
std::optional<double> metresOf(const std::string& value);

}  // namespace scanmill::town
