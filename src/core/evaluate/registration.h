#pragma once

// How well clouds agree: the fitness score of the Point Cloud Library (PCL), as they lie and after its iterative
// closest point (ICP: Besl and McKay, "A method for registration of 3-D shapes", PAMI 14(2), 1992).

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Mean of the squared distances (m^2) from each point of `source` to the nearest of `target`; those farther than
// `within` (m) are left out. One-sided, and a square: two equal errors of opposite sign do not cancel, one large one
// counts more than many small ones. Points that are not finite do not count. Empty where none is left. (PCL itself
// compares its max_range with a squared distance, and gives DBL_MAX where none is left.)
std::optional<double> fitness(std::span<const Vec3f> source, std::span<const Vec3f> target,
                              double within = std::numeric_limits<double>::infinity());

// PCL's defaults.
struct IcpOptions {
  int iterations = 10;                                             // at most
  double reach = std::numeric_limits<double>::infinity();          // m; points farther apart are not matched
  double fitnessWithin = std::numeric_limits<double>::infinity();  // m, as in fitness()
};

struct Registered {
  Affine targetFromSource;  // a rigid motion; the identity where `moved` is false
  // False where ICP cannot say: fewer than three points on either side, or within reach of each other.
  bool moved = false;
  std::optional<double> unmoved;  // fitness of the clouds as they lie (m^2)
  std::optional<double> fitness;  // of the moved source (m^2)
};

// Moves `source` onto `target`, starting where they lie.
Registered registerClouds(std::span<const Vec3f> source, std::span<const Vec3f> target, const IcpOptions& options = {});

// Of repeated measurements of one thing. All zero where there are none.
struct FitnessSpread {
  std::size_t count = 0;
  double mean = 0;
  double deviation = 0;  // of the sample: n - 1
  double low = 0;
  double high = 0;
};
// Pairs without a fitness do not count.
FitnessSpread fitnessSpread(std::span<const std::optional<double>> values);

}  // namespace scanmill
