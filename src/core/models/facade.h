#pragma once

// Walls with openings, and the windows and doors that are set back in them.

#include <vector>

#include "models/models.h"

namespace scanmill::models {

constexpr double kReveal = 0.14;  // depth of the openings, m

struct Opening {
  Span u, v;  // along the wall and up it, m
  enum { Window, Door } what = Window;
};

struct FacadeLook {
  SurfaceIndex wall = 0, trim = 0, wood = 0, metal = 0, tile = 0, glass = 0, casing = 0;
  double foundation = -0.4;  // where walls begin, m
  double top = 6;            // where walls end, m
  bool shutters = false;
};

// Appends a wall with its windows and doors. In `wallFrame` x runs along the wall (to the right, seen from outside), y
// up, z outwards. Only fronts have shutters.
void addFacade(Shape& shape, const FacadeLook& look, const Affine& wallFrame, double width,
               const std::vector<Opening>& openings, bool front);

}  // namespace scanmill::models
