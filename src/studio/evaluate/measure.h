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
  double setupSeconds = 0;  // wall time of making the method and of preparing it for the first shot
  // Wall time of a shot (s): the median, the least and the largest over all repeats of a sensor's shots. Several
  // sensors count by their numbers of shots.
  double scanSeconds = 0;
  double fastest = 0;
  double slowest = 0;
  std::map<std::string, double> stages;  // s per scan, by the method's own account, summed over its threads
  std::uint64_t memoryBytes = 0;         // by the method's own account
  std::uint64_t residentBytes = 0;       // by how much the process grew; 0 where it did not grow

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
  // Fast scans are repeated, at most 30 times, until so much time (s) is spent on a shot: what lasts a few milliseconds
  // is easily disturbed.
  double leastSeconds = 0;
  bool clouds = true;  // whether distances between clouds are measured, of the whole and of each group of beams
  // The channels that are traced while time is taken. For the errors, these and kErrorChannels are traced.
  Channels channels;
  // Gives the noise-free intensity of each beam from what a method met. Null where intensities are not compared.
  std::function<std::vector<float>(const Shot&, const Hits&)> intensity;
  // Is asked between scans; true ends the measurement with an Error.
  std::function<bool()> stop;
};

// Whether any beam of the shots meets anything in truth.
bool anyHit(std::span<const TrueShot> shots);

// Traces the truth of shots, edges and intensities included.
std::vector<TrueShot> trueShots(const Scene& scene, std::vector<Shot> shots, const MeasureOptions& options);

// Measures the method that `make` makes; that its set-up can be timed, it is made here. All shots must be of the scene.
Measurement measure(const std::function<std::unique_ptr<Method>()>& make, const Scene& scene,
                    std::span<const TrueShot> shots, const MeasureOptions& options);

// The points of the hits in the sensor's frame (m); misses have none.
std::vector<Vec3f> hitPoints(const Shot& shot, const Hits& hits);

}  // namespace scanmill
