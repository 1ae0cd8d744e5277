#pragma once

// Measures one setting of one method on some shots: the time and memory that it takes, and its errors.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evaluate/beam_errors.h"
#include "evaluate/cloud_errors.h"
#include "methods/method.h"

namespace scanmill {

struct Cost {
  double setupSeconds = 0;  // wall time of creating the method and of preparing it for the first shot
  // Wall time of a scan (s): the median, the least and the largest over all scans of a sensor. For several sensors,
  // each is a mean weighted by the sensors' numbers of scans.
  double scanSeconds = 0;
  double fastest = 0;
  double slowest = 0;
  std::map<std::string, double> stages;  // s per scan, by the method's own account, summed over its threads
  std::uint64_t memoryBytes = 0;         // by the method's own account
  std::uint64_t residentBytes = 0;       // growth of the process's resident memory; 0 if it did not grow

  double beamsPerSecond(std::uint64_t beamsPerScan) const {
    return scanSeconds > 0 ? static_cast<double>(beamsPerScan) / scanSeconds : 0;
  }
};

struct Measurement {
  Cost cost;
  BeamErrors errors;
  CloudErrors cloud;
  std::vector<std::string> warnings;
};

struct MeasureOptions {
  int repeats = 3;  // timed scans of each shot, after one that is not timed; with 0 no time is taken
  // Scans are repeated, at most 30 times, until this time (s) is spent on a shot, since measurements of a few
  // milliseconds are easily disturbed.
  double leastSeconds = 0;
  bool clouds = true;  // measure distances between clouds, for the complete cloud and for each group of beams
  // The channels that are traced while time is taken. For the errors, these and kErrorChannels are traced.
  Channels channels;
  // Returns the noise-free intensity of each beam from a method's hits. Null if intensities are not compared.
  std::function<std::vector<float>(const Shot&, const Hits&)> intensity;
  // Called between scans; if it returns true, the measurement ends with an Error.
  std::function<bool()> stop;
};

// True if any beam of the shots has a true hit.
bool anyHit(std::span<const TrueShot> shots);

// Traces the truth of shots, edges and intensities included.
std::vector<TrueShot> trueShots(const Scene& scene, std::vector<Shot> shots, const MeasureOptions& options);

// Measures the method that `make` creates. It is created here so that its set-up can be timed. All shots must be of the
// scene.
Measurement measure(const std::function<std::unique_ptr<Method>()>& make, const Scene& scene,
                    std::span<const TrueShot> shots, const MeasureOptions& options);

// Returns the points of the hits in the sensor's frame (m); misses have none.
std::vector<Vec3f> hitPoints(const Shot& shot, const Hits& hits);

}  // namespace scanmill
