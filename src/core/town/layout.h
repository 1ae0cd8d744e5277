#pragma once

// The plan of a town: its character, its roads, its plots, and the ground. Coordinates are in the town's frame (m); the
// main road passes the origin along +x. Outside this folder only tests include this header.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "models/models.h"
#include "models/occupancy.h"
#include "town/character.h"
#include "town/geometry.h"
#include "town/map.h"
#include "town/relief.h"
#include "town/roads.h"

namespace scanmill::town {

// Polygons of land beside the roads: woods, meadows, water, parking lots, squares.
class Areas {
 public:
  static constexpr double kReach = 8;  // m, largest distance that outsideHard() returns

  void add(MapArea area);
  const std::vector<MapArea>& list() const { return areas_; }

  // Both functions look for the smallest area that contains `p`: landAt() returns the area's kind, indexAt() the area's
  // index in list(). They return nullopt if no area contains `p`.
  std::optional<Land> landAt(const Point2& p) const;
  std::optional<std::uint32_t> indexAt(const Point2& p) const;
  // Returns the distance (m) to the nearest edge of water, a parking lot or a square: negative inside, at most kReach.
  double outsideHard(const Point2& p) const;

 private:
  static constexpr double kCell = 32;  // m, side of a grid cell
  std::vector<MapArea> areas_;
  std::vector<double> sizes_;       // m^2, area of each item of areas_
  models::CellIndex cells_{kCell};  // by cell, indices of the areas within kReach
};

enum class GroundKind { Road, Parking, Curb, Verge, Shoulder, Sidewalk, Driveway, Path, Lawn, Water, Lot, Paved };

// A rectangle that stores the sine and cosine of its yaw, so that many points can be tested quickly.
struct TurnedRectangle : models::Footprint {
  explicit TurnedRectangle(const models::Footprint& f) : Footprint(f), cosine(std::cos(yaw)), sine(std::sin(yaw)) {}

  // Returns how far (m) a point is beyond the rectangle's sides in x or in y, whichever is farther; negative inside.
  double outside(const Point2& p) const {
    const double dx = p.x - center.x;
    const double dy = p.y - center.y;
    return std::max(std::abs(dx * cosine + dy * sine) - halfX, std::abs(dy * cosine - dx * sine) - halfY);
  }

  const double cosine, sine;
};

// A rectangle whose ground differs from the ground around it: a driveway, a forecourt, a path in a park.
struct Patch {
  TurnedRectangle rectangle;
  GroundKind kind = GroundKind::Driveway;
  bool parks = false;  // true: a car may park here
};

// A piece of land along a road, with or without a building.
struct Plot {
  std::uint32_t number = 0;
  std::uint32_t road = 0;
  int side = 1;             // 1: at the left of the road's line; -1: at its right
  double from = 0, to = 0;  // m along the road, ends of the plot
  bool built = false;
  bool bare = false;  // true: open land, with only a hedge or fence along the road
  double depth = 9;   // m, depth of the building
  models::Fencing fencing = models::Fencing::None;
  double setback = 0;  // m from the plot's edge at the road to the building
};

// A building with an arbitrary outline.
struct PlacedBlock {
  models::Block block;      // relative to the centre of `about`
  models::Footprint about;  // the rectangle around the building
  Point2 entrance;          // a point in front of the wall that faces the road
  double height = 0;        // m, height of the ground at the entrance
};

// A rectangle of level ground, under a building and up to half a metre around it.
struct Terrace {
  TurnedRectangle rectangle;
  double height = 0;  // m
};

// A hole in a road's surface.
struct Pothole {
  Point2 center;
  double radius = 0.3, depth = 0.04;  // m
};

constexpr double kPathHalf = 0.9;  // m, half of the width of a path whose width no map gives

class Layout {
 public:
  static constexpr double kBeyond = 130;  // m by which the main road extends beyond its built-up part
  static constexpr double kEdge = 20;     // m by which the ground extends beyond the roads

  Layout(const Parameters& keys, std::uint64_t townSeed);
  Layout(const Parameters& keys, std::uint64_t townSeed, const MapPlace& map);

  // Returns half the side length (m) of the square ground that a town with these parameters needs.
  static double reachOf(const Parameters& parameters);

  const std::vector<Road>& roads() const { return network_.roads(); }  // the main road comes first
  const Road& mainRoad() const { return roads().front(); }
  Beside besideAt(const Point2& p) const { return network_.at(p); }
  // Returns the spot `along` metres along a plot's road and `depth` metres into the plot, with the road's yaw.
  models::Spot inPlot(const Plot& plot, double along, double depth) const {
    const Road& road = roads()[plot.road];
    return besideRoad(road, along, plot.side * (road.section.half + road.section.outer() + depth));
  }
  // True if the point is in a pothole, or less than `reach` (m) from a pothole's rim.
  bool nearPothole(const Point2& p, double reach) const;
  // kindAt() returns the kind of ground at `p`, heightAt() the height (m) of the ground. At a border between two kinds
  // the height depends on `kind`, for instance above or below a curb. `beside`: besideAt(p).
  GroundKind kindAt(const Beside& beside, const Point2& p) const;
  double heightAt(GroundKind kind, const Beside& beside, const Point2& p) const;
  double heightAt(const Point2& p) const;
  // Returns the point `above` metres above the ground at `p`.
  Vec3d onGround(const Point2& p, double above = 0) const { return {p.x, p.y, heightAt(p) + above}; }

  // Returns signed distances (m) from the lines between kinds of ground: the edges of the parking lane, the
  // carriageway, the curb, the verge and the paved ground. A distance is zero on its line. `edge`: Beside::edge.
  static std::array<double, 5> borders(double edge, const CrossSection& section);
  // Returns the distance (m) to the nearest patch: negative inside a patch, at most kPatchReach.
  double outsidePatches(const Point2& p) const;

  Parameters parameters;
  std::uint64_t seed;
  Character character;
  // Describes the town: district and season and, for towns from a map, the main road and the origin's coordinates.
  std::string about;
  std::vector<Plot> plots;
  std::vector<models::House> houses;  // the height of a house's pose is the height of the ground at the door
  std::vector<PlacedBlock> blocks;
  std::vector<models::Footprint> covers;  // rectangles of ground that are covered by houses, garages and blocks
  Areas areas;
  std::vector<MapBarrier> barriers;  // barriers of the map; empty without a map
  std::vector<MapTree> trees;        // trees of the map; empty without a map
  std::vector<Patch> patches;
  std::vector<Pothole> potholes;
  double mainFrom = 0, mainTo = 0;  // m along the main road, the ends of its built-up part
  double halfSide = 0;              // m, half of the side of the square of ground

 private:
  void drawRoads();
  void drawSideRoads();
  void drawPotholes();
  void drawRoundabout();
  bool isClear(const Point2& p, double reach, std::uint32_t exceptRoad) const;
  void drawLand();
  bool tryAddLand(Land land, const Road& road, int side, double along, double width, double depth);
  void addEntrances(Land land, const models::Footprint& area, double length);
  void addAllPlots();
  // Adds a house at the corner of the main road and a side road that has joins, the next in the main road's direction
  // `direction` (1 or -1). Returns where the rows beside the house begin: m along the main and along the side road.
  std::pair<double, double> addCornerHouse(const Road& road, int direction);
  void addPlots(const Road& road, int side, double from, double to);
  // Returns the distance (m) from the road's centre line to the building line of attached houses.
  double buildingLine(const Road& road, int side) const;
  struct PlotHouse;
  PlotHouse drawPlotHouse(Draw& draw, const Road& road, const Plot& plot) const;
  bool buildOn(const Plot& plot, const Road& road, const PlotHouse& plotHouse, Draw& draw);
  void addRearBuildings(const Plot& plot);
  // Adds a building without windows. `walls`: its outline; `rise`: height of its gable roof (m), 0: the roof is flat.
  void addPlainBuilding(const models::Footprint& walls, double height, double rise);
  void addGroundInFront(const models::House& house, double yaw, double width, double outer, Draw& draw);
  bool addDriveway(const models::House& house, double yaw, double outer, Draw& draw);
  models::Fencing drawFencing(Draw& draw, double setback) const;
  // Adds a strip of ground that begins at `inner` and extends `length` m towards the road. `yaw`: yaw of the plot's
  // house or of the area, whose -y axis points to the road; `half`: half of the strip's width (m).
  void addStrip(const Point2& inner, double yaw, double half, double length, GroundKind kind);
  // Sets the water level of each area that is water: the level is below the lowest point of the area's shore.
  void findWaterLevels();
  // The constructor's last step: sets water levels and the heights of buildings, and levels the ground at buildings.
  void setLevels();
  void takeRoads(const MapPlace& map);
  void takeBuildings(const MapPlace& map);
  void cover(const MapBuilding& building, const models::Footprint& around);
  void arrangePlots();
  double addBarePlots(const Road& road, int side, double from, double to);
  // True if all points of a grid over `f` are at least `gap` m from roads and sidewalks. `step`: the grid's spacing as
  // a fraction of half the rectangle's side.
  bool isOffRoads(const models::Footprint& f, double gap, double step = 1) const;
  const Patch* patchAt(const Point2& p) const;
  GroundKind landAt(const Point2& p) const;
  // The terms and factors of heightAt(), which layout.cpp describes.
  double hillsAt(const Point2& p) const;
  double carriagewayHeight(double inside, const Point2& p) const;
  double rollingOfLand(const Beside& beside, double edge, double hard, const Point2& p) const;
  double bankHeight(const Beside& beside, double edge, double hard, const Point2& p) const;
  double grainOf(GroundKind kind, const Beside& beside, double edge, const Point2& p) const;
  double field(Field name, const Point2& p, double size) const { return relief({seed, name}, p.x, p.y, size); }
  double lowering(const Beside& beside, const Point2& p) const;
  double levelling(const Point2& p, double natural) const;
  double snowOn(const Beside& beside, const Point2& p) const;
  static void addToCells(const models::Footprint& f, std::uint32_t index, models::CellIndex& cells);

  static constexpr double kPatchCell = 8;   // m, side of a cell of the grid that finds patches
  static constexpr double kPatchReach = 4;  // m, largest distance from a patch at which the patch is still found
  RoadNetwork network_;
  std::vector<Terrace> terraces_;
  models::CellIndex patchCells_{kPatchCell}, terraceCells_{kPatchCell}, potholeCells_{kPatchCell};
  models::Occupancy occupied_;       // ground that houses, garages and land of tryAddLand() occupy
  std::vector<double> waterLevels_;  // m, for each item of areas.list(); 0: not water
};

models::Model makeGround(SceneBuilder& builder, const Layout& layout);
// Places houses, plants, vehicles, people and all other objects.
void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown);

}  // namespace scanmill::town
