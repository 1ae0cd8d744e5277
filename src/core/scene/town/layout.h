#pragma once

// The plan of a town: what kind of place the seed has drawn, its roads, its plots, and the ground under all of it. In
// the town's frame, metres; the main road passes the origin along +x. Nothing outside this folder and town.cpp includes
// this header.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "config/fields.h"
#include "scene/parts/occupancy.h"
#include "scene/parts/parts.h"
#include "scene/town/roads.h"

namespace scanmill::town {

using parts::Draw;

enum class District { Rural, Suburban, Dense };
enum class Season { Summer, Autumn, Winter };

// The keys of `town:` in a scene file.
struct Parameters {
  std::string district = "any";   // or rural, suburban, dense
  std::string season = "summer";  // or any, autumn, winter
  double length = 300;            // m, of the main road between its first and last plot
  double slope = 1;               // factors of what the seed draws
  double greenery = 1;
  double vehicles = 1;
  double people = 1;
  double detail = 1;  // factor on the number of leaves
};

Parameters readParameters(Fields& fields);

// What kind of place it is: drawn once for each seed, so that no two are alike.
struct Character {
  Character(const Parameters& parameters, std::uint64_t seed);

  District district = District::Suburban;
  Season season = Season::Summer;
  double foliage = 1;    // part of their leaves that trees have kept
  double snow = 0;       // m, where nobody clears it
  double snowBanks = 0;  // m, beside the roads, where ploughs leave them
  double wear = 0;       // of the roads' surface, 0 to 1: potholes and repairs
  CrossSection main, side;
  int sideRoads = 3;
  double bend = 0.4;                      // rad, by how much the main road's heading wanders
  double hills = 3;                       // m, amplitude of what varies over 200 m
  double banks = 3;                       // m, amplitude of what varies over 45 m, away from the roads
  double undulation = 0.2;                // m, of lawns
  double setback = 4, setbackSpread = 2;  // m, from the plots' edge to the houses
  double built = 0.8;                     // share of the plots with a house
  double plotWidth = 18;                  // m, mean
  int floorsLow = 1, floorsHigh = 2;
  double hedges = 0.4, fences = 0.3;  // shares of the plots with one towards the road
  double avenue = 0.4;                // share of the places along the verge or the gardens' front with a tree
  double gardenTrees = 1;             // per plot
  double gardenBushes = 3;            // per plot
  double woods = 0.3;                 // share of the free land that is wooded
  double parked = 0.3;                // share of the parking bays, or of the places along the curb, that is taken
  double traffic = 1;                 // vehicles on the lanes, per 100 m
  double people = 4;                  // per 100 m of road
  double clutter = 6;                 // benches, bins, boxes, bollards, ... per 100 m of road
};

enum class GroundKind { Road, Parking, Curb, Verge, Shoulder, Sidewalk, Driveway, Path, Lawn };

// A rectangle of other ground within a plot, from the road's edge inwards.
struct Patch {
  parts::Footprint place;
  GroundKind kind = GroundKind::Driveway;
};

struct Plot {
  std::uint32_t number = 0;
  std::uint32_t road = 0;
  int side = 1;             // 1: to the left of the road's line
  double from = 0, to = 0;  // m along the road
  bool built = false;
  parts::House house;  // its place has the ground's height at the door
  parts::Fencing fencing = parts::Fencing::None;
  double setback = 0;
};

// Ground that is made level, for a house or a garage and half a metre about it.
struct Terrace {
  parts::Footprint place;
  double height = 0;
};

// A hole in a road's surface.
struct Pothole {
  Point2 center;
  double radius = 0.3, depth = 0.04;  // m
};

class Layout {
 public:
  Layout(const Parameters& parameters, std::uint64_t seed);

  const Parameters& parameters() const { return parameters_; }
  const Character& character() const { return character_; }
  std::uint64_t seed() const { return seed_; }
  const RoadNetwork& roads() const { return roads_; }
  const std::vector<Plot>& plots() const { return plots_; }
  const std::vector<Patch>& patches() const { return patches_; }
  const std::vector<Terrace>& terraces() const { return terraces_; }
  const std::vector<Pothole>& potholes() const { return potholes_; }
  // A pothole is nearer than its radius and so many metres.
  bool nearPothole(const Point2& p, double reach) const;
  // The part of the main road that is built on: distances along its line (m).
  double mainFrom() const { return mainFrom_; }
  double mainTo() const { return mainTo_; }
  double half() const { return half_; }  // of the square of ground, m

  // The kind of ground at a point, and its height, which is that of the kind at its border.
  GroundKind kindAt(const Beside& beside, const Point2& p) const;
  double heightAt(GroundKind kind, const Beside& beside, const Point2& p) const;
  double heightAt(const Point2& p) const;

  // Where the ground changes from kind to kind: zero on each of these lines.
  std::array<double, 5> borders(const Beside& beside) const;
  // How far outside of the nearest patch (m, negative inside; far ones count as 4 m).
  double outsidePatches(const Point2& p) const;

 private:
  using Cells = std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>;
  void drawRoads();
  void drawPlots();
  void drawPotholes();
  void addPlots(std::uint32_t road, int side, double from, double to);
  bool fits(const parts::Footprint& f, double gap) const;
  const Patch* patchAt(const Point2& p) const;
  double base(const Point2& p) const;
  double lowering(const Beside& beside, const Point2& p) const;
  double levelling(const Point2& p, double natural) const;
  double snowOn(const Beside& beside, const Point2& p) const;
  static void enter(const parts::Footprint& f, std::uint32_t index, Cells& cells);

  Parameters parameters_;
  std::uint64_t seed_;
  Character character_;
  RoadNetwork roads_;
  std::vector<Plot> plots_;
  std::vector<Patch> patches_;
  Cells patchCells_;
  std::vector<Terrace> terraces_;
  Cells terraceCells_;
  std::vector<Pothole> potholes_;
  Cells potholeCells_;
  parts::Occupancy houses_;
  double mainFrom_ = 0, mainTo_ = 0, half_ = 0;
};

parts::Model makeGround(SceneBuilder& builder, const Layout& layout);
// Places houses, plants, vehicles, people and all else.
void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown);

}  // namespace scanmill::town
