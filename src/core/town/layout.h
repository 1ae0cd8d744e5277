#pragma once

// The plan of a town: its character, its roads, its plots, and the ground. Coordinates are in the town's frame (m); the
// main road passes the origin along +x. Outside this folder only tests include this header.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "models/models.h"
#include "models/occupancy.h"
#include "town/areas.h"
#include "town/character.h"
#include "town/map_place.h"
#include "town/relief.h"
#include "town/roads.h"

namespace scanmill::town {

enum class GroundKind { Road, Parking, Curb, Verge, Shoulder, Sidewalk, Driveway, Path, Lawn, Water, Lot, Paved };

// A rectangle whose ground differs from the ground around it: a driveway, a lot for parking, a path in a park.
struct Patch {
  models::Footprint place;
  GroundKind kind = GroundKind::Driveway;
  bool parks = false;  // true: a car may park here
};

struct Plot {
  std::uint32_t number = 0;
  std::uint32_t road = 0;
  int side = 1;             // 1: at the left of the road's line; -1: at its right
  double from = 0, to = 0;  // m along the road, ends of the plot
  bool built = false;
  bool bare = false;  // true: open land, with only a hedge or fence along the road
  double depth = 9;   // m, depth of the building
  models::Fencing fencing = models::Fencing::None;
  double setback = 0;
};

// A building with any outline.
struct PlacedBlock {
  models::Block block;      // relative to the centre of `about`
  models::Footprint about;  // the rectangle around the building
  Point2 entrance;          // a point in front of the wall that faces the road
  double height = 0;        // m, height of the ground at the entrance
};

// A rectangle with the sine and cosine of its yaw, for many points.
struct TurnedRectangle {
  models::Footprint place;
  double cosine = std::cos(place.yaw), sine = std::sin(place.yaw);

  // Returns the distance of a point from the rectangle (m, negative inside): the larger of the distances along its two
  // axes.
  double outside(const Point2& p) const {
    const double dx = p.x - place.center.x;
    const double dy = p.y - place.center.y;
    return std::max(std::abs(dx * cosine + dy * sine) - place.halfX, std::abs(dy * cosine - dx * sine) - place.halfY);
  }
};

// A rectangle in which the ground is level: under a building and half a metre around it.
struct Terrace {
  models::Footprint place;
  double height = 0;
};

// A hole in a road's surface.
struct Pothole {
  Point2 center;
  double radius = 0.3, depth = 0.04;  // m
};

constexpr double kPathHalf = 0.9;  // m, half of the width of a path whose width no map gives

class Layout {
 public:
  static constexpr double kBeyond = 130;  // m that the main road continues beyond its built-up part
  static constexpr double kEdge = 20;     // m that the ground continues beyond the roads

  Layout(const Parameters& parameters, std::uint64_t seed);
  Layout(const Parameters& parameters, std::uint64_t seed, const MapPlace& map);

  // Returns a description of the town: the district, the season, and with a map the main road and the latitude and
  // longitude of the frame's origin.
  const std::string& about() const { return about_; }
  // Returns half of the side of the square of ground (m) that these parameters need.
  static double reachOf(const Parameters& parameters);

  const Parameters& parameters() const { return parameters_; }
  const Character& character() const { return character_; }
  std::uint64_t seed() const { return seed_; }
  const RoadNetwork& roads() const { return roads_; }
  const std::vector<Plot>& plots() const { return plots_; }
  // Returns the houses. The height of a house's pose is the height of the ground at the door.
  const std::vector<models::House>& houses() const { return houses_; }
  const std::vector<PlacedBlock>& blocks() const { return blocks_; }
  // Returns rectangles of ground that are covered by houses, garages and blocks.
  const std::vector<models::Footprint>& covers() const { return covers_; }
  const Areas& areas() const { return areas_; }
  // Returns the id of the map's relation of a building, by the number of its house or block; 0: none.
  std::int64_t relationOf(std::uint32_t number) const {
    const auto found = relations_.find(number);
    return found == relations_.end() ? 0 : found->second;
  }
  // Returns the barriers and the trees of the map; empty without a map.
  const std::vector<MapBarrier>& barriers() const { return barriers_; }
  const std::vector<MapTree>& trees() const { return trees_; }
  const std::vector<Patch>& patches() const { return patches_; }
  const std::vector<Pothole>& potholes() const { return potholes_; }
  // True if the point is in a pothole, or less than `reach` (m) from its rim.
  bool nearPothole(const Point2& p, double reach) const;
  // Returns the ends of the built-up part of the main road (m along its line).
  double mainFrom() const { return mainFrom_; }
  double mainTo() const { return mainTo_; }
  double half() const { return half_; }  // half of the side of the square of ground (m)

  // kindAt() returns the kind of ground at a point, heightAt() the height of the ground (m). At a border between two
  // kinds the height depends on `kind`, for instance above or below a curb.
  GroundKind kindAt(const Beside& beside, const Point2& p) const;
  double heightAt(GroundKind kind, const Beside& beside, const Point2& p) const;
  double heightAt(const Point2& p) const;
  // Returns the point `above` metres above the ground.
  Vec3d onGround(const Point2& p, double above = 0) const { return {p.x, p.y, heightAt(p) + above}; }

  // Returns signed distances (m) to the lines between kinds of ground: the edges of the parking lane, the carriageway,
  // the curb, the verge and the paved ground. A distance is zero on its line. `edge`: Beside::edge.
  static std::array<double, 5> borders(double edge, const CrossSection& section);
  // Returns the distance to the nearest patch (m): negative inside a patch, at most 4 m.
  double outsidePatches(const Point2& p) const;

 private:
  using Cells = std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>;
  void drawRoads();
  void drawPlots();
  void drawPotholes();
  void drawRoundabout();
  void drawLand();
  bool addLand(Land land, std::uint32_t road, int side, double along, double width, double depth);
  void addPlots(std::uint32_t road, int side, double from, double to);
  models::Fencing drawFencing(Draw& draw, double setback) const;
  // Adds a strip of ground from the point `inner` at a house towards the road. `yaw` is the yaw of the house, `half` is
  // half of the strip's width (m).
  void addStrip(const Point2& inner, double yaw, double half, double length, GroundKind kind);
  // Sets the water level of each area that is water: the level is below the lowest point of the area's shore.
  void findWaterLevels();
  // The last step of building a layout: finds the levels of water, gives buildings the height of the ground at their
  // door, and levels the ground around them.
  void settle();
  void takeRoads(const MapPlace& map);
  void takeBuildings(const MapPlace& map);
  void cover(const MapBuilding& building, const models::Footprint& about);
  void arrangePlots();
  bool isOffRoads(const models::Footprint& f, double gap) const;
  const Patch* patchAt(const Point2& p) const;
  GroundKind landAt(const Point2& p) const;
  double base(const Point2& p) const;
  double field(Field of, const Point2& p, double size) const { return relief({seed_, of}, p.x, p.y, size); }
  double lowering(const Beside& beside, const Point2& p) const;
  double levelling(const Point2& p, double natural) const;
  double snowOn(const Beside& beside, const Point2& p) const;
  static void enter(const models::Footprint& f, std::uint32_t index, Cells& cells);

  Parameters parameters_;
  std::uint64_t seed_;
  Character character_;
  std::string about_;
  RoadNetwork roads_;
  std::vector<Plot> plots_;
  std::vector<Patch> patches_;
  std::vector<TurnedRectangle> patchPlaces_;  // of patches_, when all are known
  Cells patchCells_;
  std::vector<Terrace> terraces_;
  std::vector<TurnedRectangle> terracePlaces_;  // of terraces_
  Cells terraceCells_;
  std::vector<Pothole> potholes_;
  Cells potholeCells_;
  std::vector<models::House> houses_;
  std::vector<PlacedBlock> blocks_;
  std::vector<models::Footprint> covers_;
  models::Occupancy taken_;  // ground that houses, garages and land of addLand() occupy
  double mainFrom_ = 0, mainTo_ = 0, half_ = 0;
  Areas areas_;
  std::vector<double> waterLevels_;                  // m, by area; 0 for areas that are not water
  std::map<std::uint32_t, std::int64_t> relations_;  // by the numbers of houses and blocks
  std::vector<MapBarrier> barriers_;
  std::vector<MapTree> trees_;
};

models::Model makeGround(SceneBuilder& builder, const Layout& layout);
// Places houses, plants, vehicles, people and all other objects.
void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown);

}  // namespace scanmill::town
