#pragma once

// Surface elements (surfels): discs that approximate a surface near each of the points that were measured on it
// (Pfister, Zwicker, van Baar, Gross, "Surfels: surface elements as rendering primitives", SIGGRAPH 2000).

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
// neighbours scatter least (Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992); if they lie
// on a line, as along one ring of a scan, up to eight times as many neighbours are used. With n neighbours within the
// distance d, a point's share of the surface is pi d^2 / n. `normals` is empty or has one per point; normals that are
// not zero replace the estimate. Positions must be finite. Runs on all cores.
std::vector<Surfel> surfelsOf(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                              const SurfelOptions& options);

// Thins points to one in each cube of a grid of this spacing (m), the nearest to the cube's centre. Returns the indices
// of the kept points, ascending.
std::vector<std::size_t> thinned(const std::vector<Vec3f>& positions, double spacing);

}  // namespace scanmill
