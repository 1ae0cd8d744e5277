#pragma once

// How a sensor moved between two scans, by the planes that both see. Clouds of beams lie in rings around the sensor
// that move with it, so that matching points with points (ICP) holds the rings still and not the place; a plane is the
// same whichever beams met it.

#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// A piece of a plane, in the sensor's frame.
struct PlanePiece {
  Vec3d center;
  Vec3d normal;      // unit
  double reach = 0;  // m, from its center to its farthest corner
};

struct PlaneMotion {
  Pose targetFromSource;
  double error = 0;         // m, standard error of the translation, all directions together
  std::size_t matched = 0;  // pieces of the source that lie on the target's
  std::string failure;      // why it is no result; empty: it converged
};

// Gauss and Newton's steps on the distances of the source's centers from the target's planes next to them, outliers
// weighed down (Cauchy's weights, their scale falling to 3 cm); started from the best of all horizontal shifts up to
// 3 m. Converged where the steps vanish and the planes hold the translation in every direction.
PlaneMotion registerPlanes(const std::vector<PlanePiece>& source, const std::vector<PlanePiece>& target);

}  // namespace scanmill
