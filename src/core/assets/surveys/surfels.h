#pragma once

// Surface elements (surfels): discs that approximate a surface near each measured point (Pfister, Zwicker, van Baar,
// Gross, "Surfels: surface elements as rendering primitives", SIGGRAPH 2000).

#include <cstddef>
#include <vector>

#include "assets/asset.h"
#include "base/vec.h"

namespace scanmill {

struct Surfel {
  Vec3f normal;      // unit length; its sign is arbitrary
  float radius = 0;  // m, radius of the disc
};

// Returns one surfel per point, in the order of the points. The normal is the direction in which a point and its
// neighbours scatter least (Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992). If these
// points lie on a line, as along one ring of a scan, up to eight times as many neighbours are used. A point with n
// neighbours within the distance d represents the area pi d^2 / n of the surface. `normals` is empty or has one normal
// per point, which replaces the estimate unless it is zero. Positions must be finite. Runs on all cores.
std::vector<Surfel> surfelsOf(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                              const SurfelOptions& options);

// Thins points to one in each cube of a grid of this spacing (m): the point nearest to the cube's centre. Returns the
// indices of the kept points, ascending.
std::vector<std::size_t> thinned(const std::vector<Vec3f>& positions, double spacing);

}  // namespace scanmill
