#pragma once

// Measures how well two point clouds agree: by the fitness score of the Point Cloud Library (PCL), before and after
// PCL's iterative closest point (ICP: Besl and McKay, "A method for registration of 3-D shapes", PAMI 14(2), 1992).

#include <cstddef>
#include <optional>
#include <span>

#include "base/vec.h"

namespace scanmill {

inline constexpr int kIcpIterations = 10;  // PCL's default of the maximum number of iterations of ICP

struct Registered {
  // False if ICP cannot find a motion, for example because a cloud has fewer than three points.
  bool moved = false;
  // Fitness: the mean of the squared distances (m^2) from each point of the source to the nearest point of the target,
  // not from the target to the source. Points that are not finite are ignored; if a cloud has no others, there is no
  // fitness. Equal errors of opposite sign do not cancel; one large error counts more than many small ones.
  std::optional<double> unmoved{};  // fitness of the source at its given position
  std::optional<double> fitness{};  // fitness after the motion; without a motion the same as `unmoved`
};

// Registers `source` to `target` with ICP, starting from the given positions. `iterations`: their maximum number.
Registered registerClouds(std::span<const Vec3f> source, std::span<const Vec3f> target,
                          int iterations = kIcpIterations);

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
