#pragma once

// Walls with openings, and the windows and doors that are set back in them.

#include <vector>

#include "models/models.h"

namespace scanmill::models {

constexpr double kReveal = 0.14;  // m, how far windows and doors are set back

struct Opening {
  Span u, v;  // extents along the wall and upwards, m
  enum { Window, Door } what = Window;
};

struct FacadeLook {
  SurfaceIndex wall = 0, trim = 0, wood = 0, metal = 0, tile = 0, glass = 0, casing = 0;
  double foundation = -0.4;  // m, height where walls begin
  double top = 6;            // m, height where walls end
  bool shutters = false;
};

// Appends a wall with its windows and doors. `wallFrame` has x along the wall (to the right, seen from outside), y up
// and z outwards; `width` is the length of the wall (m). Shutters are added only if `front` is set.
void addFacade(Shape& shape, const FacadeLook& look, const Affine& wallFrame, double width,
               const std::vector<Opening>& openings, bool front);

}  // namespace scanmill::models
