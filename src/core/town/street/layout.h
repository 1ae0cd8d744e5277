#pragma once

// The plan of the procedural street: its keys, its roads, lots and houses, and the functions that build it and place
// objects. Only this folder includes this header.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "models/models.h"
#include "scene/builder.h"

namespace scanmill::street {

using namespace models;

// The keys of `street:` in a scene file. Lengths are in metres; densities are objects per 100 m of street, on both
// sides together.
struct Parameters {
  double length = 200, roadWidth = 7, parkingWidth = 2.2, curbHeight = 0.12, sidewalkWidth = 2.5, frontGarden = 4;
  double terrain = 80, beyond = 150;
  bool crossStreet = true;
  double buildings = 0.9, boundaries = 0.6;  // fraction of the lots with a house, fraction with a hedge or fence
  double trees = 22, bushes = 20, cars = 14, traffic = 2, trucks = 1, buses = 0.5, motorcycles = 2, bicycles = 6;
  double cyclists = 1, pedestrians = 10, signs = 6, lamps = 5, furniture = 10, shelters = 1;

  int count(double density) const;
};

Parameters readParameters(Fields& fields);

// A plot along the street. `side` is -1 for y < 0, at the right of vehicles that drive along +x, and 1 for y > 0.
struct Lot {
  int side = 1;
  Span x;
  Fencing fencing = Fencing::None;
  Span driveway;         // empty (low == high): no driveway
  bool lowered = false;  // true: the curb is lowered at the driveway
  Span walkway;
  std::uint32_t number = 0;
};

enum class Ground { Road, Parking, Curb, LoweredCurb, Sidewalk, Ramp, Driveway, Path, Terrain };

// The plan of the street, in the street's frame (m). Distances from the centre line are valid for both sides of the
// road.
struct Layout {
  Layout(const Parameters& parameters, std::uint64_t seed);

  static constexpr double kCurb = 0.15;         // m, width of a curb stone
  static constexpr double kRamp = 0.45;         // m, width of the slope in the sidewalk at a driveway
  static constexpr double kLoweredCurb = 0.03;  // m, height of a lowered curb
  static constexpr double kDrivewayDepth = 7;   // m, length of driveways beyond the front line
  static constexpr double kPathDepth = 1.5;     // m, length of paths beyond the front line; largest setback of a house
  static constexpr double kCrossSidewalkEnd = 18;  // m, largest length of the cross street's sidewalks beyond gardens

  Ground kindAt(double x, double y) const;
  // Returns the height (m) of ground of this kind at a point inside its border or on its border.
  double heightAt(Ground kind, double x, double y) const;
  double heightAt(double x, double y) const { return heightAt(kindAt(x, y), x, y); }
  bool inCorner(double x, double y) const;  // true in the squares that contain the rounded corners of the crossing
  // True if x is on the driveway or walkway (`strip`) of a lot at this side, or less than `margin` (m) from it.
  bool onStrip(Span Lot::*strip, double x, int side, double margin) const;
  // True if x is beside a parking lane, or less than `margin` (m) from its ends.
  bool besideParking(double x, double margin) const;

  Parameters p;
  std::uint64_t seed;
  double roadEdge, parkingEdge, walkInner, walkOuter, front;  // distances from the centre line, m
  double halfLength, halfX, halfY;
  bool cross;
  double crossX = 0, crossEdge = 0, crossWalk = 0, cornerRadius = 0;
  double crossSidewalkEnd = 0;
  std::vector<Span> parking;  // extents along x; the same on both sides
  std::vector<Lot> lots;
  std::vector<House> houses;

 private:
  double terrainHeight(double x, double y) const;
  void addLots(int side, Span x);
  void addCrossHouses();

  std::array<double, 12> waves_{};
};

Model makeGround(SceneBuilder& builder, const Layout& layout);
Model makeMarkings(SceneBuilder& builder, const Layout& layout);
// Places everything in the scene except ground, markings and houses.
void populate(SceneBuilder& builder, const Layout& layout, const Affine& worldFromStreet);

}  // namespace scanmill::street
