#pragma once

#include <vector>

#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// The points that a standing sensor's beams hit, in its own axes (m).
inline std::vector<Vec3f> pointsOf(const Shot& shot, const Hits& hits) {
  const BeamTable& beams = *shot.beams;
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits.hit(i)) continue;
    Vec3d p = beams.direction[i] * double{hits.range[i]};
    if (!beams.origin.empty()) p += Vec3d(beams.origin[i]);
    points.push_back(Vec3f(p));
  }
  return points;
}

}  // namespace scanmill
