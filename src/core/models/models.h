#pragma once

// The workshop of procedural scenes: numbers, a mesh under construction, and one function per kind of object. Frame of
// an object: metres, x forward, z up, ground at z = 0. Nothing outside scene/ includes this header.

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

// What kind of object a random number is for. Every kind has numbers of its own, so that more objects of one kind leave
// the others as they are. The values are part of what a seed means: append, never renumber.
enum class Kind : std::uint32_t {
  Plot = 1,
  Lot,
  Terrain,
  House,
  Tree,
  Bush,
  Hedge,
  Car,
  Truck,
  Bus,
  Bicycle,
  Motorcycle,
  Person,
  Sign,
  Lamp,
  Light,
  Furniture,
  Shelter,
  Boundary,
  Traffic,
  Cyclist,
  Markings,
  Town,
  SideRoad,
  Wood,
  Hedgerow,
  Undergrowth,
  Animal,
  WorkVehicle,
  Clutter,
  Roadworks,
  Pothole,
  Cover,
  Map,
  Wire,
  Grass,
};

// The random numbers of one object, drawn one after the other.
class Draw {
 public:
  Draw(std::uint64_t seed, Kind kind, std::uint32_t object = 0);
  double next();  // in (0, 1)
  double in(double low, double high) { return low + (high - low) * next(); }
  double around(double mean, double share) { return mean * in(1 - share, 1 + share); }
  int below(int count) { return static_cast<int>(next() * count); }
  bool chance(double probability) { return next() < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  Vec3d direction();  // uniform on the unit sphere

 private:
  RandomAddress address_;
  RandomBlock block_{};
  std::size_t used_ = 4;
};

// `from`, from + step and so on, as long as they are below `to`.
std::vector<double> steps(double from, double to, double step);

// make(0) to make(count - 1).
template <class Make>
auto makeForms(int count, const Make& make) {
  std::vector<decltype(make(0))> forms;
  forms.reserve(static_cast<std::size_t>(std::max(0, count)));
  for (int form = 0; form < count; ++form) forms.push_back(make(form));
  return forms;
}

using SurfaceIndex = std::uint16_t;  // index into Mesh::surfaces

struct Point2 {
  double x = 0;
  double y = 0;
};

constexpr double lerp(double a, double b, double t) {
  return a + (b - a) * t;
}
double smooth(double t);  // smoothstep of t, which is clamped to [0, 1]

Affine at(const Vec3d& position);
Affine at(const Vec3d& position, double yaw);
// Places the origin at the position and the z axis along the direction; x and y are any axes that fit.
Affine along(const Vec3d& position, const Vec3d& direction);

// A mesh of a scene, and the box around it (m).
struct Model {
  std::uint32_t mesh = 0;
  Box bounds;
};

// A mesh under construction. All that is appended is transformed by `frame`. Lengths are in metres.
class Shape {
 public:
  Shape(SceneBuilder& builder, std::string name);

  SurfaceIndex surface(std::string_view className, std::string_view material);

  void triangle(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, const Vec3d& c);
  void quad(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);
  void box(SurfaceIndex surface, const Vec3d& center, const Vec3d& size);
  void boxAt(SurfaceIndex surface, const Affine& place, const Vec3d& size);
  void ball(SurfaceIndex surface, const Vec3d& center, const Vec3d& radii, int segments = 12);
  // A closed pipe along a polyline with a radius at each point.
  void pipe(SurfaceIndex surface, const std::vector<Vec3d>& points, const std::vector<double>& radii, int segments = 8);
  void tube(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double radiusA, double radiusB, int segments = 8);
  // Revolves a profile of (radius, z) about the z axis. Outside is to the right of the profile's direction, which goes
  // from bottom to top.
  void revolve(SurfaceIndex surface, const Affine& place, const std::vector<Point2>& profile, int segments,
               bool closed = false);
  void torus(SurfaceIndex surface, const Affine& place, double radius, double thickness, int segments, int around = 8);
  // A prism over a convex polygon (counter-clockwise in x, y), from z = 0 to `thickness`. Its top has the surface
  // `front`, the rest `rim`.
  void prism(SurfaceIndex front, SurfaceIndex rim, const Affine& place, const std::vector<Point2>& polygon,
             double thickness);
  // Quads between rows of points, all rows being equally long. `wrap` joins the last point of a row to its first; `of`
  // gives the surface of a quad. Where corners coincide, a quad becomes a triangle. Seen from outside, a quad's corners
  // go round counter-clockwise from a point to the next one of its row.
  void grid(const std::vector<std::vector<Vec3d>>& rows, bool wrap,
            const std::function<SurfaceIndex(int row, int column)>& of);

  // Adds the mesh to the scene.
  Model finish();

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

constexpr double kGarageFrom = 6.2;  // m behind the front of its house
constexpr double kGarageBeside = 0.25;
constexpr double kGarageWidth = 3.3;
constexpr double kGarageDepth = 5.8;

enum class Roof { Flat, Gable, CrossGable, Hip };

// In the house's frame the front wall lies in y = 0 and faces -y. It reaches along x from 0 to width, and the house
// along y from 0 to depth.
struct House {
  Affine place;  // where it stands
  double width = 10, depth = 9;
  int floors = 2, columns = 4, doorColumn = 1;
  Roof roof = Roof::Gable;
  bool shop = false;
  std::uint32_t number = 0;
  std::optional<double> top;  // of the roof, m; where there is none, as floors and slope need
  // The ground before the front that details may take (m): house_details.h. None: the walls stay bare, the house empty.
  std::optional<double> forecourt;
  bool garage = false, ivy = false;

  double doorX() const { return width * (doorColumn + 0.5) / columns; }
  Vec3d garageMiddle() const { return {width + kGarageBeside + kGarageWidth / 2, kGarageFrom + kGarageDepth / 2, 0}; }
};

// A building over any outline, with a flat roof and rooms behind its windows, its ground at z = 0.
struct Block {
  std::vector<Point2> outline;              // counter-clockwise, without its first point at the end
  std::vector<std::vector<Point2>> courts;  // clockwise
  int floors = 2;                           // none: a shed without windows
  double height = 0;                        // of the walls, m, which end 0.4 m above the roof; 0: as the floors need
  Point2 entrance;                          // the wall that is nearest to it has the door
  bool shop = false;
  std::uint32_t number = 0;
};

enum class Fencing { None, Pickets, Bars, Brick, Hedge };

Model makeHouse(SceneBuilder& builder, std::uint64_t seed, const House& house);
Model makeBlock(SceneBuilder& builder, std::uint64_t seed, const Block& block);

struct TreeModel {
  Model model;
  double crownRadius = 2;
};
constexpr int kTreeForms = 8;
constexpr int kBroadleafForms = 6;  // the first of them
// `detail`: factor on the number of leaves, whose area in all stays the same. `foliage`: part of its leaves that a
// broadleaf has kept, 0 to 1; what has lost them shows its twigs. `ragged`: how far a broadleaf's crown is from being
// round, 0 to 1: heavier on one side, with limbs that reach out and gaps between them.
TreeModel makeTree(SceneBuilder& builder, std::uint64_t seed, int form, double detail = 1, double foliage = 1,
                   double ragged = 0);
Model makeBush(SceneBuilder& builder, std::uint64_t seed, int form, double foliage = 1);
Model makeHedge(SceneBuilder& builder, std::uint64_t seed);  // 2 m along x, 0.6 m wide
// 2 m along x, leaves all through it, of a height and depth by its form.
Model makeHedgerow(SceneBuilder& builder, std::uint64_t seed, int form);
// Shrubs taller than a man.
Model makeUndergrowth(SceneBuilder& builder, std::uint64_t seed, int form, double foliage = 1);

enum class CarForm { Hatchback, Sedan, Wagon, Suv, Van, Pickup, Delivery };
constexpr int kCarForms = 7;
Model makeCar(SceneBuilder& builder, std::uint64_t seed, CarForm form, int number);
Model makeTruck(SceneBuilder& builder, std::uint64_t seed, int form);
Model makeBus(SceneBuilder& builder, std::uint64_t seed);
enum class WorkVehicle { Trailer, Caravan, Tractor, Excavator, Count };
Model makeWorkVehicle(SceneBuilder& builder, std::uint64_t seed, WorkVehicle what, int number);
// Tyre and rim in the plane y = 0 about the origin, outside to +y.
void appendWheel(Shape& shape, std::string_view className, const Affine& place, double radius, double width);

// Where a rider touches a bicycle, in its frame.
struct BicycleFit {
  Vec3d saddle, leftGrip, rightGrip, leftPedal, rightPedal;
};
Model makeBicycle(SceneBuilder& builder, std::uint64_t seed, int form, BicycleFit* fit = nullptr);
Model makeMotorcycle(SceneBuilder& builder, std::uint64_t seed, int form);

Model makePedestrian(SceneBuilder& builder, std::uint64_t seed, int form);
// The moments of a stride, in their order and evenly apart.
struct Walker {
  std::vector<Model> moments;
  double stride = 1.3;  // m, from a moment to its next time
};
Walker makeWalker(SceneBuilder& builder, std::uint64_t seed, int form);
Model makeRider(SceneBuilder& builder, std::uint64_t seed, int form, const BicycleFit& fit);

constexpr int kAnimalForms = 6;
constexpr int kPetForms = 3;  // dogs and cats, the first of them; the others graze
Model makeAnimal(SceneBuilder& builder, std::uint64_t seed, int form, int number);

enum class TrafficSign { SpeedLimit, Warning, Priority, Stop, Parking, GiveWay };
constexpr int kSigns = 6;
Model makeSign(SceneBuilder& builder, std::uint64_t seed, TrafficSign sign, int number);  // faces +x
Model makeLamp(SceneBuilder& builder, std::uint64_t seed, int form);                      // its arm reaches to +x
Model makeTrafficLight(SceneBuilder& builder, std::uint64_t seed);                        // faces +x
// Of wood, its crossarm along y. Where its wires hang (m).
struct UtilityPole {
  Model model;
  std::vector<Vec3d> insulators;
  Vec3d telephone;
};
UtilityPole makeUtilityPole(SceneBuilder& builder, std::uint64_t seed);

enum class Furnishing { Bin, WheelieBin, Hydrant, Bench, LetterBox, PowerBox, BicycleRack, Bollard, Planter, Count };
Model makeFurnishing(SceneBuilder& builder, std::uint64_t seed, Furnishing what);
// A cone stands as it is, a barrier runs along x, a shed opens to -y.
enum class Clutter { Cone, Barrier, Skip, Cart, Pallets, Heap, Shed, Pond, Fountain, Swing, WoodPile, Count };
Model makeClutter(SceneBuilder& builder, std::uint64_t seed, Clutter what, int number);
Model makeShelter(SceneBuilder& builder, std::uint64_t seed);                   // open to -y
Model makeColumn(SceneBuilder& builder, std::uint64_t seed);                    // for posters
Model makeFencePanel(SceneBuilder& builder, std::uint64_t seed, Fencing what);  // 2 m along x, centred

}  // namespace scanmill::models
