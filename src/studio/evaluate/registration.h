#pragma once

// Measures how well two point clouds agree: by the fitness score of the Point Cloud Library (PCL), before and after
// PCL's iterative closest point (ICP: Besl and McKay, "A method for registration of 3-D shapes", PAMI 14(2), 1992).

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "base/vec.h"

namespace scanmill {

// The options of ICP, with PCL's defaults.
struct IcpOptions {
  int iterations = 10;                                             // maximum number of iterations
  double reach = std::numeric_limits<double>::infinity();          // maximum distance of matched points (m)
  double fitnessWithin = std::numeric_limits<double>::infinity();  // larger distances do not count in the fitness (m)
};

struct Registered {
  // False if ICP cannot find a motion: a cloud has fewer than three points, or fewer than three points can be matched.
  bool moved = false;
  // Fitness: the mean of the squared distances (m^2) from each point of the source to the nearest point of the target,
  // not from the target to the source. Distances above IcpOptions::fitnessWithin and points that are not finite are
  // ignored; if no distance remains, there is no fitness. Equal errors of opposite sign do not cancel; one large error
  // counts more than many small ones.
  std::optional<double> unmoved{};  // fitness of the source at its given position
  std::optional<double> fitness{};  // fitness after the motion; without a motion the same as `unmoved`
};

// Registers `source` to `target` with ICP, starting from the given positions.
Registered registerClouds(std::span<const Vec3f> source, std::span<const Vec3f> target, const IcpOptions& options = {});

// Statistics of the fitness (m^2) over repeated measurements. All values are zero if there are no measurements.
struct FitnessSpread {
  std::size_t count = 0;
  double mean = 0;
  double deviation = 0;  // sample standard deviation, with the divisor n - 1
  double low = 0, high = 0;
};
// Returns the statistics of the given values; absent values are ignored.
FitnessSpread fitnessSpread(std::span<const std::optional<double>> values);

}  // namespace scanmill
