#pragma once

// How well do repeated scans of one thing agree? The ICP protocol of the paper "LiDAR-GEIL: LiDAR GPU Exploitation in
// Lightsimulations" (its Figures 10, 11 and 13): scan a thing several times from each pose with other noise, crop the
// scans to it, move one onto the other and take the fitness.

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "evaluate/registration.h"
#include "pipeline/plan.h"

namespace scanmill {

// Of the scans of one pose with one noise.
struct PointCount {
  double mean = 0;
  std::uint64_t least = 0;
  std::uint64_t most = 0;
};

// Of all ordered pairs of scans with different seeds, one noise each: mean squared distances (m²) from the points of
// the source to the nearest ones of the target.
struct LevelFitness {
  FitnessSpread registered;  // after ICP, of the pairs that it moved: it takes three points on each side
  FitnessSpread unmoved;     // as the scans lie, of the pairs that have points; the poses are the same, so the truth is
  std::uint64_t pairs = 0;   // all
};

// One pose of the sensor.
struct RepeatedPlace {
  std::uint32_t frame = 0;
  std::string object;
  double distance = 0;                // m, from the sensor to the object's box
  std::vector<PointCount> points;     // per noise level
  std::vector<LevelFitness> fitness;  // [source level * levels + target level]
};

struct RepeatedView {
  std::size_t method = 0;  // index into Repeatability::methods
  std::string name;    // "small_box front": scene, its seed where there are several, trajectory, and likewise sensor
  std::string sensor;  // "lidar0 (OS1-128, 128 x 1024 beams)"
  std::vector<RepeatedPlace> places;
};

struct Repeatability {
  static constexpr int kSchemaVersion = 1;
  std::string programVersion;
  std::string pipelineName;
  std::string pipelineText;  // as Pipeline::text: with the overrides as comments
  std::uint64_t seed = 0;    // of the first scan; the others follow
  std::uint32_t scans = 0;   // of each pose
  double margin = 0;         // m
  IcpOptions icp;
  std::vector<std::string> methods;
  std::vector<std::string> levels;
  std::size_t reference = 0;  // level
  std::vector<RepeatedView> views;
  std::vector<std::string> warnings;  // of what is measured, but says nothing

  std::vector<std::string> objects() const;  // that are looked at, each once
  std::vector<std::string> sensors() const;  // likewise
  const LevelFitness& at(const RepeatedPlace& place, std::size_t source, std::size_t target) const {
    return place.fitness[source * levels.size() + target];
  }
};

// Of two pairs, which are one pair there and back, there is no deviation to speak of.
inline bool hasDeviation(const FitnessSpread& spread) {
  return spread.count > 2;
}

struct RepeatabilityOptions {
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// The pipeline's `repeatability:` says what is compared; see study/repeatability/repeatability_choice.h. The plan must
// know of repeatabilityChannels(). Throws InputError for unusable input.
Repeatability measureRepeatability(const Plan& plan, const RepeatabilityOptions& options);

std::string repeatabilityJson(const Repeatability& result);  // the same figures give the same bytes
std::string repeatabilityCsv(const Repeatability& result);   // a row per pose and pair of noise levels
// index.html and its charts: repeatability_report.h.

}  // namespace scanmill
