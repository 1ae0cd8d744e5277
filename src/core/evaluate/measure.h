#pragma once

// One setting of one method on some shots: what it takes and how it errs.

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
  double setupSeconds = 0;  // making the method and preparing it for the first shot, wall
  // Per shot, wall: the median, least and largest over all repeats of a sensor's shots; of several sensors their mean,
  // each by its number of shots.
  double scanSeconds = 0;
  double fastest = 0;
  double slowest = 0;
  std::map<std::string, double> stages;  // s per scan, by the method's own account, summed over its threads
  std::uint64_t memoryBytes = 0;         // by the method's own account
  std::uint64_t residentBytes = 0;       // by how much the process grew, 0 where it did not

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
  int repeats = 3;  // timed scans of each shot, after one that is not timed; 0: no time is taken
  // Fast scans are repeated further until so much time (s) is spent on a shot, at most 30 times: each is soon
  // disturbed.
  double leastSeconds = 0;
  bool clouds = true;  // measure distances between clouds too, of the whole and of each group of beams
  Channels channels;   // that are traced while time is taken; kErrorChannels and these are traced for the errors
  // Noise-free intensities of what a method met; null: not compared.
  std::function<std::vector<float>(const Shot&, const Hits&)> intensity;
  // Asked between scans; true ends the measurement with an Error.
  std::function<bool()> stop;
};

// Whether any beam meets anything in truth.
bool anyHit(std::span<const TrueShot> shots);

// The truth of shots, edges included.
std::vector<TrueShot> trueShots(const Scene& scene, std::vector<Shot> shots, const MeasureOptions& options);

// `make` makes the method, so that its set-up can be timed. All shots must be of the scene.
Measurement measure(const std::function<std::unique_ptr<Method>()>& make, const Scene& scene,
                    std::span<const TrueShot> shots, const MeasureOptions& options);

// Where the hits are, in the sensor's frame (m), misses left out.
std::vector<Vec3f> hitPoints(const Shot& shot, const Hits& hits);

}  // namespace scanmill
