#pragma once

// Measures how well clouds agree: the fitness score of the Point Cloud Library (PCL), for the clouds as they are and
// after its iterative closest point (ICP: Besl and McKay, "A method for registration of 3-D shapes", PAMI 14(2), 1992).

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Returns the mean of the squared distances (m^2) from each point of `source` to the nearest point of `target`;
// distances above `within` (m) and points that are not finite do not count. Returns nothing if no distance is left. The
// mean is one-sided, and of squares: two equal errors of opposite sign do not cancel, and one large error counts more
// than many small ones. (PCL itself compares its max_range with a squared distance, and returns DBL_MAX if no distance
// is left.)
std::optional<double> fitness(std::span<const Vec3f> source, std::span<const Vec3f> target,
                              double within = std::numeric_limits<double>::infinity());

// The values are PCL's defaults.
struct IcpOptions {
  int iterations = 10;                                             // upper bound
  double reach = std::numeric_limits<double>::infinity();          // m; points farther apart are not matched
  double fitnessWithin = std::numeric_limits<double>::infinity();  // m; `within` of fitness()
};

struct Registered {
  Affine targetFromSource;  // a rigid motion; the identity if `moved` is false
  // False if ICP cannot find a motion: a cloud has fewer than three points, or fewer than three within reach.
  bool moved = false;
  std::optional<double> unmoved;  // the fitness of the clouds as they are (m^2)
  std::optional<double> fitness;  // the fitness after the motion (m^2)
};

// Moves `source` onto `target` by ICP, starting from their given positions.
Registered registerClouds(std::span<const Vec3f> source, std::span<const Vec3f> target, const IcpOptions& options = {});

// The spread of the fitness over repeated measurements (m^2). All values are zero if there are no measurements.
struct FitnessSpread {
  std::size_t count = 0;
  double mean = 0;
  double deviation = 0;  // the sample's standard deviation: divided by n - 1
  double low = 0;
  double high = 0;
};
// Values that are absent do not count.
FitnessSpread fitnessSpread(std::span<const std::optional<double>> values);

}  // namespace scanmill
