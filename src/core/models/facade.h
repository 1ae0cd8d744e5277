#pragma once

// Parts of houses and vehicles: walls with windows and doors, the details of a facade, and lofted bodies.

#include <cstdint>
#include <vector>

#include "models/models.h"

namespace scanmill::models {

constexpr double kReveal = 0.14;  // m, depth of windows and doors behind the wall's face

struct Opening {
  Span u, v;  // extents along the wall and upwards, m
  enum { Window, Door } what = Window;
};

// Returns the material of a house's walls: bricks or plaster, light or dark.
inline const char* wallMaterial(bool isBrick, Draw& draw) {
  if (isBrick) return draw.chance(0.65) ? "brick" : "brick_light";
  return draw.chance(0.3) ? "plaster" : draw.chance(0.7) ? "plaster_tinted" : "plaster_dark";
}

struct FacadeLook {
  SurfaceIndex wall = 0, trim = 0, wood = 0, metal = 0, tile = 0, glass = 0, casing = 0, cloth = 0;
  double foundation = -0.4;  // m, height where walls begin
  double top = 6;            // m, height where walls end
  bool shutters = false;
};

// Adds the surfaces of a facade to a shape. `wall`: material of the walls. `draw` selects the materials of the windows'
// frames and panes: most houses have coated panes, through which little light comes back from inside.
FacadeLook facadeLook(Shape& shape, const char* wall, Draw& draw);

// Appends a wall with its windows and doors, and curtains and blinds behind most windows. `wallFrame` has x along the
// wall (to the right, seen from outside), y up and z outwards; `width` is the length of the wall (m).
void addFacade(Shape& shape, const FacadeLook& look, const Affine& wallFrame, double width,
               const std::vector<Opening>& openings, Draw& draw);

// Dimensions of a house (m).
struct HouseMeasures {
  double base = 0.3;    // height of the ground floor above the ground
  double storey = 2.9;  // height from floor to floor
  double sill = 0.8;    // height of the windows' lower edge above the floor of their storey
  double windowWidth = 1.2, windowHeight = 1.4;
};

// Adds rooms and fittings to a house, and to some houses bands, corner stones, bays, porches, ivy, awnings or
// a garage. `shape` is in the house's frame.
void addHouseDetails(Shape& shape, std::uint64_t seed, const House& house, const FacadeLook& look,
                     const HouseMeasures& measures);

// The lofted body of a car, van, bus or cab. Lengths are in metres; x is forward, from the middle of the vehicle.
struct BodyForm {
  const char* className = "car";
  double length = 4.3, width = 1.78;
  double floor = 0.2;
  double belt = 0.92, beltRise = 0.02;       // lower edge of the windows at x = 0; its rise per metre to the rear
  double roofHalf = 0.56;                    // half of the roof's width
  double noseTaper = 0.13, tailTaper = 0.1;  // fraction of the width lost at the nose and at the tail
  double bulge = 0.09;                       // how far the bumpers protrude
  std::vector<Point2> profile{};             // (x, z) of the upper edge, from the tail to the nose
  Span windscreen{}, rearWindow{};           // extents along x; empty: no such window
  std::vector<Span> sideWindows{};           // extents along x
  std::vector<double> axles{};               // positions along x
  double wheelRadius = 0.31, wheelWidth = 0.2;
  Span bed{};                       // extent along x of a pickup's covered bed
  bool mirrors = true;              // true: the body has mirrors and door handles
  const char* paint = "car_paint";  // material of the body
};

// Appends the body, its wheels, lights and plates.
void appendBody(Shape& shape, const BodyForm& form);

}  // namespace scanmill::models
