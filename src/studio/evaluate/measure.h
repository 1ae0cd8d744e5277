#pragma once

// Measures one setting of one method on some shots: its time, memory and errors.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evaluate/beam_errors.h"
#include "methods/method.h"

namespace scanmill {

struct Pipeline;

struct Cost {
  double setupSeconds = 0;  // wall time for creating the method and preparing it for the first shot
  // Wall time (s) of a scan: the median, minimum and maximum over all scans of a sensor. For several sensors, each
  // value is a mean that is weighted by the sensors' numbers of scans.
  double scanSeconds = 0;
  double fastest = 0, slowest = 0;
  std::map<std::string, double> stages;  // time per scan (s), as the method reports it, summed over its threads
  std::uint64_t memoryBytes = 0;         // size of the memory that the method reports (bytes)
  std::uint64_t residentBytes = 0;       // growth of the process's resident memory; 0 if it did not grow
};

struct Measurement {
  Cost cost;
  BeamErrors errors;
  std::vector<std::string> warnings;
};

struct MeasureOptions {
  int repeats = 3;  // least number of timed scans per shot, after one that is not timed; 0: no timing
  // Scans of a shot are repeated until they took this time (s) together, or until there are 30 scans: other processes
  // easily disturb measurements of a few milliseconds.
  double leastSeconds = 0;
  // The channels that are traced while time is measured. For the errors, kErrorChannels are traced in addition.
  Channels channels{};
  // Returns the intensity of each beam from a method's hits. If null, intensities are not compared.
  std::function<std::vector<float>(const Shot&, const Hits&)> intensity{};
  // Called between scans. If it returns true, measure() throws Error.
  std::function<bool()> stop{};
};

// Returns a function for MeasureOptions::intensity that applies only those effects of a pipeline that set the
// intensity. If such an effect adds noise (its key `noise`), the noise is equal for all methods. The hits must have the
// channels that the effects read. The function is null if no effect of the pipeline sets the intensity. `pipeline` and
// `scene` must outlive the function.
std::function<std::vector<float>(const Shot&, const Hits&)> intensityOfEffects(const Pipeline& pipeline,
                                                                               const Scene& scene);

// Throws Error if beams fire several rays, since methods are compared beam by beam.
void requireOneRay(const Hits& hits);

// Returns for each beam 1 if it is near an edge, otherwise 0. For this, eight neighbouring beams are traced at `angle`
// (rad) above, below, left, right and diagonally. The beam is near an edge if a neighbour hits another instance or
// class, if only one of the two has a hit, or if their ranges differ by more than a tenth of the range, which is more
// than the slope of a surface explains.
std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle);

// True if at least one beam of the shots has a true hit.
bool anyHit(std::span<const TrueShot> shots);

// Returns the shots with their exact hits, their beams near edges and, if options.intensity is not null, intensities.
std::vector<TrueShot> trueShots(const Scene& scene, std::vector<Shot> shots, const MeasureOptions& options);

// Measures the method that `make` creates; its creation is timed as set-up. All shots must belong to `scene`.
Measurement measure(const std::function<std::unique_ptr<Method>()>& make, const Scene& scene,
                    std::span<const TrueShot> shots, const MeasureOptions& options);

// Returns the points (m) of all hits in beam order, in the frame that Shot::deskew states. Misses have no point.
std::vector<Vec3f> hitPoints(const Shot& shot, const Hits& hits);

// Returns the distance (m) of each point of `from` to the nearest finite point of `to`; NaN for points that are not
// finite, and if `to` has no finite point. Float is exact enough, since the points are float32 too.
std::vector<float> nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to);

}  // namespace scanmill
