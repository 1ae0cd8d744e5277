#pragma once

// Finds how a sensor moved between two scans by the planes that both see. The points of a scan lie in rings that move
// with the sensor, so that matching points with points (ICP) holds the rings still, not the place; a plane is the same
// whichever beams met it.

#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// A piece of a plane, in the sensor's frame.
struct PlanePiece {
  Vec3d center;
  Vec3d normal;      // of length 1
  double reach = 0;  // m, from the center to the farthest corner
};

struct PlaneMotion {
  Pose targetFromSource;
  double error = 0;         // m, standard error of the translation, all directions together
  std::size_t matched = 0;  // pieces of the source that lie on pieces of the target
  std::string failure;      // why there is no result; empty where the search converged
};

// Moves the pieces of the source onto those of the target: Gauss-Newton steps on the distances of the source's centers
// from the planes of the target next to them, outliers weighed down (Cauchy's weights, their scale falling to 3 cm).
// The search starts from the best of all horizontal shifts up to 3 m. It has converged where the steps vanish and the
// planes hold the translation in every direction.
PlaneMotion registerPlanes(const std::vector<PlanePiece>& source, const std::vector<PlanePiece>& target);

}  // namespace scanmill
