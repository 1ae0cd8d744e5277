#pragma once

// Places objects on the free ground of a town.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "town/layout.h"

namespace scanmill::town {

using models::Footprint;
using models::Model;
using models::Spot;

class Placer {
 public:
  static constexpr int kTries = 16;     // number of random positions that are tried for an object
  static constexpr double kGap = 0.15;  // m, least distance between objects

  Placer(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown);

  // Places a model upright, with its origin `sink` metres below the ground, even if the spot is not free.
  void put(const Model& m, const Spot& s, const std::string& name, double sink = 0);
  // Places the model if the spot is free. Otherwise returns false.
  bool tryPut(const Model& m, const Spot& s, const std::string& name);
  // Places a model on wheels, tilted with the ground, if the spot is free and not in noParking; else returns false.
  bool tryPark(const Model& m, const Spot& s, const std::string& name);
  // Places a model on wheels even if the spot is not free.
  void park(const Model& m, const Spot& s, const std::string& name);
  // Places a moving model. In a plain town the model stands still, or is left out if its path begins below the ground.
  void putMoving(std::uint32_t mesh, const std::string& name, const std::shared_ptr<const Movement>& movement,
                 const std::shared_ptr<const Animation>& animation = nullptr);
  // Adds a mesh whose points are in the town's frame.
  void putShape(models::Shape& shape) {
    const std::string name = shape.mesh.name;
    builder.place(shape.finish().mesh, worldFromTown, name);
  }
  // Calls tryPlace("PREFIX NUMBER") with the prefix's next number. Returns the result; if true, the number is used up.
  template <class TryPlace>
  bool tryNumbered(const std::string& prefix, const TryPlace& tryPlace) {
    int& number = numbers[prefix];
    if (!tryPlace(prefix + " " + std::to_string(number + 1))) return false;
    ++number;
    return true;
  }
  // Returns make(builder, seed, form, arguments...) for each form from 0 to count - 1.
  template <class Make, class... Arguments>
  auto forms(int count, const Make& make, const Arguments&... arguments) const {
    std::vector<decltype(make(builder, layout.seed, 0, arguments...))> built;
    for (int form = 0; form < count; ++form) built.push_back(make(builder, layout.seed, form, arguments...));
    return built;
  }

  SceneBuilder& builder;
  const Layout& layout;
  const Affine& worldFromTown;
  // True if a rectangle's centre is on the town's ground and no driveway, path or placed object overlaps the rectangle.
  bool isFree(const Footprint& f) const { return isOnGround(f.center) && driveways.isFree(f) && occupancy.isFree(f); }
  // True if a point is on the town's ground, not at its edge.
  bool isOnGround(const Point2& p) const {
    constexpr double kEdge = 3;  // m, least distance from the edge of the ground
    return std::max(std::abs(p.x), std::abs(p.y)) < layout.halfSide - kEdge;
  }

  models::Occupancy occupancy;  // rectangles that are covered by objects
  models::Occupancy driveways;  // driveways and paths, which must stay clear
  models::Occupancy noParking;  // rectangles where nothing on wheels may be placed
  // A traffic light at the main road, for both directions.
  struct Light {
    static constexpr double kPeriod = 44;  // s, period of the light
    static constexpr double kRed = 16;     // s, duration of red in each period
    double stopAgainstLine;                // m along the road, where vehicles against its line stop
    double stopWithLine;                   // m along the road, where vehicles along its line stop
    double offset;                         // s, time at which a period begins
    bool marked;                           // true: there is a stop line on the road
  };
  std::vector<Light> lights;

  // Returns the model for `kind` and `form`. The first call for these builds the model with `make`.
  template <class Make>
  const Model& model(models::Kind kind, int form, const Make& make) {
    const auto [found, isNew] = models_.try_emplace({kind, form});
    if (isNew) found->second = make();
    return found->second;
  }
  // The models of trees built so far, by form, variant, and whether the tree is far from roads.
  std::map<std::tuple<int, int, bool>, std::optional<models::TreeModel>> trees;
  std::map<std::string, int> numbers;  // numbers that tryNumbered() has used up, by prefix

 private:
  std::map<std::pair<models::Kind, int>, Model> models_;
};

// anyCar() and anyTruck() return the model of a random car or lorry, busOf() the model of the bus.
const Model& anyCar(Placer& placer, Draw& draw);
const Model& anyTruck(Placer& placer, Draw& draw);
const Model& busOf(Placer& placer);

// Appends a quad of paint on a road. `along`: m along the road's line; `lateral`: m to the left of the line.
void paintBar(models::Shape& s, models::SurfaceIndex paint, const Layout& l, const Road& road,
              const models::Span& along, const models::Span& lateral);

// Returns the kind of sign for vehicles that come out of a side road; nullopt if there is no sign.
std::optional<models::TrafficSign> signAtMouth(const Layout& l, const Road& sideRoad);

void placeHouses(Placer& placer);
void placeBoundaries(Placer& placer);
void placeRails(Placer& placer);
void placeMarkings(Placer& placer);
void placeCovers(Placer& placer);
void placeFixtures(Placer& placer);
void placeWires(Placer& placer);
void placeClutter(Placer& placer);
void placeAnimals(Placer& placer);
void placeVehicles(Placer& placer);  // stationary vehicles
void placeTraffic(Placer& placer);   // vehicles and cyclists that drive
void placePeople(Placer& placer);
void placeMapTrees(Placer& placer);  // called before objects are placed that the map lacks
void placeTrees(Placer& placer);
void placeWoods(Placer& placer);
void placeBushes(Placer& placer);
void placeGrass(Placer& placer);

}  // namespace scanmill::town
