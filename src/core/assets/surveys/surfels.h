#pragma once

// Surface elements (surfels; Pfister, Zwicker, van Baar, Gross, "Surfels: surface elements as rendering primitives",
// SIGGRAPH 2000): what a surface is near each of the points that were measured on it.

#include <cstddef>
#include <vector>

#include "assets/asset.h"
#include "base/vec.h"

namespace scanmill {

struct Surfel {
  Vec3f normal;      // unit; which of the two sides it is on is not known
  float radius = 0;  // m, of a disc
};

// One a point, in their order. The normal is the direction in which a point and its neighbours scatter least (Hoppe et
// al., "Surface reconstruction from unorganized points", SIGGRAPH 1992); where they lie on a line, as along one ring of
// a scan, up to eight times as many are taken. With n neighbours within the distance d a point's share of the surface
// is pi d^2 / n. Where `normals` are given, one a point, they are kept. Positions are finite. Runs on all cores.
std::vector<Surfel> surfelsOf(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                              const SurfelOptions& options);

// Of several points in one cube of a grid of this spacing (m) the one nearest to the cube's middle: their indices,
// ascending.
std::vector<std::size_t> thinned(const std::vector<Vec3f>& positions, double spacing);

}  // namespace scanmill
