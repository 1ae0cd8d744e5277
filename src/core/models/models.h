#pragma once

// Builds the objects of procedural scenes: one function per kind of object, their random streams, and their meshes. An
// object's frame: metres, x forward, z up, ground at z = 0. Only town/ and tests include this header.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/random.h"
#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scene/scene.h"

namespace scanmill::models {

// The purpose of random numbers: the shape of a kind of object, its positions in a town, or a property of the town.
// Each kind has its own random stream and is drawn in one place of the code, so that more objects of one kind do not
// change other kinds. What a seed generates depends on these values: append new kinds, never renumber.
// clang-format off
enum class Kind : std::uint32_t {
  Plot = 1, Lot, Terrain, House, Tree, Bush, Car = 8, Truck, Bus, Bicycle, Motorcycle, Person, Sign, Lamp, Light,
  Furniture, Shelter, Boundary, Traffic, Cyclist, Markings, Town, SideRoad, Wood, Hedgerow, Undergrowth, Animal,
  WorkVehicle, Clutter, Roadworks, Pothole, Cover, Map, Wire, Grass,
  // Shapes.
  Block, Facade, HouseDetails, Crown, Tuft, Paint, Walker, Motorcyclist, RiddenBicycle, RiddenMotorcycle, UtilityPole,
  // Properties of the town, and positions in it.
  Season, DrySoil, Roundabout, MapRoad, Land, MapBuilding, BarePlot, MapFencing, PlotBoundary, Rails, LightPhase,
  Crossing, Signals, GardenThings, TownPond, Square, Animals, RoadLamps, RoadSigns, MouthSign, Shelters, RoadFurniture,
  MapTree, Avenue, ParkTrees, GardenTrees, GardenBushes, WoodLattice, GrassAlongRoads, SidewalkParking, ParkedCar,
  ForecourtCars, StandingVehicles, PassingTraffic, SideTraffic, RoadCyclists, PeopleCounts, Pedestrian, ParkedBicycles,
  SidewalkCyclist, ParkedMotorcycles, EgoLine, Sidewalk, Panel, BuildingLine, RearBuildings, CornerHouse,
};
// clang-format on

// The random stream of an object: each call returns the next number of the stream.
class Draw {
 public:
  Draw(std::uint64_t seed, Kind kind, std::int64_t object = 0);
  double next();  // uniform in (0, 1)
  double in(double low, double high) { return low + (high - low) * next(); }
  double around(double mean, double share) { return mean * in(1 - share, 1 + share); }
  int below(int count) { return static_cast<int>(next() * count); }
  bool chance(double probability) { return next() < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  // Returns a random item of a list.
  template <class List>
  const auto& itemOf(const List& items) {
    return items[static_cast<std::size_t>(below(static_cast<int>(items.size())))];
  }
  Vec3d direction();  // uniform on the unit sphere

 private:
  RandomAddress address_;
  RandomBlock block_{};
  std::size_t used_ = 4;
};

// Returns the numbers begin, begin + step, begin + 2 * step, ... that are below `end`.
std::vector<double> steps(double begin, double end, double step);

using SurfaceIndex = std::uint16_t;  // index into Mesh::surfaces

struct Point2 {
  double x = 0;
  double y = 0;
};

constexpr double lerp(double a, double b, double t) {
  return a + (b - a) * t;
}
constexpr Point2 lerp(const Point2& a, const Point2& b, double t) {
  return {lerp(a.x, b.x, t), lerp(a.y, b.y, t)};
}
// Returns the corners of a regular polygon about the origin, counter-clockwise from the angle `firstAngle` (rad).
std::vector<Point2> regularPolygon(int corners, double radius, double firstAngle = 0);
// Returns the corners of a horizontal rectangle at the height `z`, centred at x = `middleX`, y = 0 (m).
std::vector<Vec3d> levelRectangle(double z, double halfX, double halfY, double middleX = 0);
// Calls visit(a, b) for each side of a polygon, from corner a to the next corner b.
template <class Visit>
void forSides(const std::vector<Point2>& ring, const Visit& visit) {
  for (std::size_t i = 0; i < ring.size(); ++i) visit(ring[i], ring[(i + 1) % ring.size()]);
}

double smooth(double t);  // smoothstep of t, with t clamped to [0, 1]

Affine at(const Vec3d& position);
Affine at(const Vec3d& position, double yaw);
// Returns the frame of a side view from the right: the drawing's x is forward (+x), y is up (+z), z is right (-y).
Affine sideView(const Vec3d& origin);

// A mesh of the scene and its bounding box (m).
struct Model {
  std::uint32_t mesh = 0;
  Box bounds;
  double length() const { return bounds.high.x - bounds.low.x; }
  double width() const { return bounds.high.y - bounds.low.y; }
};

// Whether the last point of a row is joined to the first point.
enum class Loop { Open, Closed };

// A mesh under construction. `frame` transforms everything that is appended. Lengths are in metres.
class Shape {
 public:
  Shape(SceneBuilder& builder, std::string name) : builder_(builder) { mesh.name = std::move(name); }

  // surface() returns the surface of a class with a material; surfaces() returns a surface for each material.
  SurfaceIndex surface(std::string_view className, std::string_view material);
  template <class... Materials>
  std::array<SurfaceIndex, sizeof...(Materials)> surfaces(std::string_view className, const Materials&... materials) {
    return {surface(className, materials)...};
  }

  void triangle(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, const Vec3d& c);
  void quad(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);
  void box(SurfaceIndex surface, const Vec3d& center, const Vec3d& size);
  void boxAt(SurfaceIndex surface, const Affine& pose, const Vec3d& size);
  void ball(SurfaceIndex surface, const Vec3d& center, const Vec3d& radii, int segments = 12);
  // Appends a pipe with closed ends along a polyline. `radii`: the radius at each point; `radius`: at all points.
  void pipe(SurfaceIndex surface, const std::vector<Vec3d>& points, const std::vector<double>& radii, int segments = 8);
  void pipe(SurfaceIndex surface, const std::vector<Vec3d>& points, double radius, int segments = 8);
  // tube() appends a straight pipe from `a` to `b`; rod() appends a pipe with one radius.
  void tube(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double radiusA, double radiusB, int segments = 8);
  void rod(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double radius, int segments = 8);
  // Appends the surface of revolution of a profile (radius, z) about the z axis of `pose`. The surface faces to the
  // right of the profile's direction: outwards where the profile goes upwards. `loop`: whether the profile is closed.
  void revolve(SurfaceIndex surface, const Affine& pose, const std::vector<Point2>& profile, int segments,
               Loop loop = Loop::Open);
  // Appends a torus about z. `thickness`: radius of its cross section (m); `corners`: the cross section's corners.
  void torus(SurfaceIndex surface, const Affine& pose, double radius, double thickness, int segments, int corners = 8);
  // Appends a prism over a convex polygon (counter-clockwise in x, y), from z = 0 to `thickness`. The top has the
  // surface `front`; the sides and the bottom have the surface `rim`.
  void prism(SurfaceIndex front, SurfaceIndex rim, const Affine& pose, const std::vector<Point2>& polygon,
             double thickness);
  // Appends quads between successive rows, which have equal numbers of points. `loop`: whether each row is closed;
  // `surfaceAt` returns the surface of a quad. A quad with two equal corners becomes a triangle. Seen from outside, the
  // corners are counter-clockwise: a point, the next point of the same row, then the points of the next row.
  void grid(const std::vector<std::vector<Vec3d>>& rows, Loop loop,
            const std::function<SurfaceIndex(int row, int column)>& surfaceAt);
  void grid(const std::vector<std::vector<Vec3d>>& rows, Loop loop, SurfaceIndex surface) {
    grid(rows, loop, [&](int, int) { return surface; });
  }

  // Adds the mesh to the scene and returns the model.
  [[nodiscard]] Model finish();

  Affine frame;
  Mesh mesh;

 private:
  std::uint32_t vertex(const Vec3d& p);

  SceneBuilder& builder_;
  std::vector<std::pair<std::string, SurfaceIndex>> surfaces_;
};

struct Span {
  double low = 0;
  double high = 0;
  bool holds(double v) const { return v > low && v < high; }
};

// Garages (m): distance behind the front of the house, gap beside its right wall, width and depth.
constexpr double kGarageFrom = 6.2, kGarageBeside = 0.25, kGarageWidth = 3.3, kGarageDepth = 5.8;

enum class Roof { Flat, Gable, CrossGable, Hip };

// A house. In its frame, the front wall is in the plane y = 0, faces -y and extends from x = 0 to `width`; the house
// extends from y = 0 to `depth` (m).
struct House {
  Affine pose{};
  double width = 10, depth = 9;
  int floors = 2, columns = 4, doorColumn = 1;
  Roof roof = Roof::Gable;
  bool shop = false;
  std::uint32_t number = 0;
  std::int64_t relation = 0;     // id of a map's relation, whose buildings are one object instance; 0: none
  std::optional<double> top{};   // m, top of the roof; not set: the height follows from floors and slope
  std::optional<double> rise{};  // m, height of a pitched roof if `top` is set; not set: it follows from a random slope
  double forecourt = 0;          // m, depth of the ground in front of the house that a bay or porch may cover
  bool garage = false, ivy = false;
  bool partyLeft = false, partyRight = false;  // true: a neighbour touches this wall, seen from the front

  double doorX() const { return width * (doorColumn + 0.5) / columns; }
  Vec3d garageMiddle() const { return {width + kGarageBeside + kGarageWidth / 2, kGarageFrom + kGarageDepth / 2, 0}; }
};

// A building with an arbitrary outline and rooms behind its windows. The ground is at z = 0.
struct Block {
  std::vector<Point2> outline;              // counter-clockwise; the first point is not repeated
  std::vector<std::vector<Point2>> courts;  // outlines of the courtyards, clockwise
  int floors = 2;                           // number of floors; 0: the building is a shed without windows
  double base = 0;                          // m, underside of a block that hangs above the ground; 0: on the ground
  double height = 0;                        // m, top of the walls; 0: follows from `floors`
  // A pitched roof rises by `rise` (m) from the walls to a ridge, whose two ends may coincide. Each corner of the
  // outline is joined to the nearest end of the ridge. If `rise` is 0, the roof is flat.
  double rise = 0;
  std::array<Point2, 2> ridge{};
  bool parapet = true;           // true: a flat roof over floors has a parapet
  bool door = true;              // true: a block on the ground has a door
  std::size_t openWalls = 1000;  // number of walls with windows, from the outline's first; the others touch houses
  Point2 entrance;               // the door is in the wall whose middle is nearest to this point
  bool shop = false;
  std::uint32_t number = 0;
  std::int64_t relation = 0;  // see House
  std::vector<Block> parts;   // not empty: the parts are built, and the block itself is not
};

enum class Fencing { None, Pickets, Bars, Brick, Hedge, Boards, Wire, GuardRail, Barrier, Count };

// The functions make...() below add a mesh to the scene. The mesh depends on the seed and on `form` or `number`, which
// select a variant of the object.

// Returns a house of this size with random windows and a random roof.
House drawHouse(Draw& draw, std::uint32_t number, double width, double depth, int floors);
Model makeHouse(SceneBuilder& builder, std::uint64_t seed, const House& house);
Model makeBlock(SceneBuilder& builder, std::uint64_t seed, const Block& block);

struct TreeModel {
  Model model;
  double crownRadius = 2;
};
constexpr int kTreeForms = 8;
constexpr int kBroadleafForms = 6;  // number of broadleaf forms; they come first among the kTreeForms forms
// Builds a tree. `form` modulo kTreeForms is the species; other forms of a species are different trees.
// `detail`: factor on the number of leaves; the total leaf area stays the same. `foliage`: fraction of the leaves that
// are still on a broadleaf tree, 0 to 1; below 0.6, twigs are added. `ragged`: irregularity of a broadleaf's crown: 0
// is a round crown; 1 is a crown that is heavier on one side, with protruding limbs and gaps between them.
TreeModel makeTree(SceneBuilder& builder, std::uint64_t seed, int form, double detail, double foliage, double ragged);
Model makeBush(SceneBuilder& builder, std::uint64_t seed, int form, double foliage);
// Builds 2 m of hedgerow along x, whose inside beams do not pass. Height and depth follow from `seed` and `form`.
Model makeHedgerow(SceneBuilder& builder, std::uint64_t seed, int form);
// Builds a group of shrubs 1.4 to 3.2 m high.
Model makeUndergrowth(SceneBuilder& builder, std::uint64_t seed, int form, double foliage);

enum class CarForm { Hatchback, Sedan, Wagon, Suv, Van, Pickup, Delivery };
constexpr int kCarForms = 7;
Model makeCar(SceneBuilder& builder, std::uint64_t seed, CarForm form, int number);
Model makeTruck(SceneBuilder& builder, std::uint64_t seed, int form);
Model makeBus(SceneBuilder& builder, std::uint64_t seed);
enum class WorkVehicle { Trailer, Caravan, Tractor, Excavator, Count };
Model makeWorkVehicle(SceneBuilder& builder, std::uint64_t seed, WorkVehicle kind, int number);
// Appends a tyre and rim about the origin of `pose`. The axle is the y axis, the outer side is at +y.
void appendWheel(Shape& shape, std::string_view className, const Affine& pose, double radius, double width);
// Appends two wheels that stand on the ground at (x, y) and (x, -y), with their outer sides away from each other.
void appendWheels(Shape& shape, std::string_view className, double x, double y, double radius, double width);

// The points of a bicycle or motorcycle that the rider touches, in the vehicle's frame (m).
struct RiderFit {
  Vec3d saddle, leftGrip, rightGrip, leftPedal, rightPedal;
};
// Build a vehicle for a rider and set `fit`; if `fit` is null, build a parked vehicle.
Model makeBicycle(SceneBuilder& builder, std::uint64_t seed, int form, RiderFit* fit = nullptr);
Model makeMotorcycle(SceneBuilder& builder, std::uint64_t seed, int form, RiderFit* fit = nullptr);

Model makePedestrian(SceneBuilder& builder, std::uint64_t seed, int form);  // a person who stands
// A walking person: one mesh for each moment of a stride, in order and evenly spaced in time.
struct Walker {
  std::vector<Model> moments;
  double stride = 1.3;  // m walked in one cycle of all moments
};
Walker makeWalker(SceneBuilder& builder, std::uint64_t seed, int form);
// A bicycle or motorcycle and its rider. With the same pose, the rider sits on the vehicle.
struct Ridden {
  Model vehicle, rider;
};
Ridden makeCyclist(SceneBuilder& builder, std::uint64_t seed, int form);
Ridden makeMotorcyclist(SceneBuilder& builder, std::uint64_t seed, int form);

constexpr int kAnimalForms = 6;
constexpr int kPetForms = 3;  // number of forms of dogs and cats; the forms after them are grazing animals
Model makeAnimal(SceneBuilder& builder, std::uint64_t seed, int form, int number);

enum class TrafficSign { SpeedLimit, Warning, Priority, Stop, Parking, GiveWay };
constexpr int kSigns = 6;
Model makeSign(SceneBuilder& builder, std::uint64_t seed, TrafficSign sign, int number);  // the sign faces +x
Model makeLamp(SceneBuilder& builder, std::uint64_t seed, int form);                      // the arm reaches to +x
Model makeTrafficLight(SceneBuilder& builder, std::uint64_t seed);                        // the lights face +x
// A wooden utility pole, whose crossarm is along y, and the points where wires are attached (m).
struct UtilityPole {
  Model model;
  std::vector<Vec3d> insulators;
  Vec3d telephone;
};
UtilityPole makeUtilityPole(SceneBuilder& builder, std::uint64_t seed);

enum class Furnishing { Bin, WheelieBin, Hydrant, Bench, LetterBox, PowerBox, BicycleRack, Bollard, Planter, Count };
Model makeFurnishing(SceneBuilder& builder, std::uint64_t seed, Furnishing kind);
// A barrier extends along x; a shed's door faces -y. Values select random streams: append new ones, never renumber.
enum class Clutter { Cone, Barrier, Skip, Pallets, Heap, Shed, Pond, Fountain, Swing, WoodPile, Count };
Model makeClutter(SceneBuilder& builder, std::uint64_t seed, Clutter clutter, int number);
Model makeShelter(SceneBuilder& builder, std::uint64_t seed);  // the shelter's open side faces -y
// Builds a fence panel 2 m long along x, whose middle is at the origin. `kind`: neither Fencing::None nor a hedge.
Model makeFencePanel(SceneBuilder& builder, std::uint64_t seed, Fencing kind, int form = 0);

}  // namespace scanmill::models
