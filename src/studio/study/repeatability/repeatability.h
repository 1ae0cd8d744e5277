#pragma once

// Measures how well repeated scans of one thing agree, by the ICP protocol of the paper "LiDAR-GEIL: LiDAR GPU
// Exploitation in Lightsimulations" (its Figures 10, 11 and 13): a thing is scanned several times from each pose with
// other noise, the scans are cropped to it, one is moved onto the other, and the fitness is taken.

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "evaluate/registration.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// How many points fall on the thing in the scans of one pose with one noise level.
struct PointCount {
  double mean = 0;
  std::uint64_t least = 0;
  std::uint64_t most = 0;
};

// The fitness of all ordered pairs of scans with different seeds, the source with one noise level and the target with
// one: mean squared distances (m²) from the points of the source to the nearest points of the target.
struct LevelFitness {
  FitnessSpread registered;  // after ICP, of the pairs that it moved: it takes three points on each side
  FitnessSpread unmoved;     // of the pairs that have points, as they lie: their poses are the same
  std::uint64_t pairs = 0;   // all pairs
};

// What was measured from one pose of the sensor.
struct RepeatedPlace {
  std::uint32_t frame = 0;
  std::string object;
  double distance = 0;                // m, from the sensor to the object's box
  std::vector<PointCount> points;     // one per noise level
  std::vector<LevelFitness> fitness;  // [source level * levels + target level]
};

struct RepeatedView {
  std::size_t method = 0;  // index into Repeatability::methods
  // "small_box front": the scene, its seed where there are several, the trajectory, and the sensor where there are
  // several.
  std::string name;
  std::string sensor;  // "lidar0 (OS1-128, 128 x 1024 beams)"
  std::vector<RepeatedPlace> places;
};

struct Repeatability {
  static constexpr int kSchemaVersion = 1;
  std::string programVersion;
  std::string pipelineName;
  std::string pipelineText;  // as Pipeline::text: with the overrides as comments
  std::uint64_t seed = 0;    // of the first scan; the other scans have the seeds that follow
  std::uint32_t scans = 0;   // from each pose
  double margin = 0;         // m; points farther from the object's box are cropped away
  IcpOptions icp;
  std::vector<std::string> methods;  // the names of the settings
  std::vector<std::string> levels;   // the names of the noise levels
  std::size_t reference = 0;         // index into levels: the level of the first charts
  std::vector<RepeatedView> views;
  std::vector<std::string> warnings;  // sentences about figures that say nothing

  std::vector<std::string> objects() const;  // the names of the objects that are looked at, each once
  std::vector<std::string> sensors() const;  // RepeatedView::sensor of the views, each once
  const LevelFitness& at(const RepeatedPlace& place, std::size_t source, std::size_t target) const {
    return place.fitness[source * levels.size() + target];
  }
};

// Whether a deviation can be told: two pairs are one pair there and back.
inline bool hasDeviation(const FitnessSpread& spread) {
  return spread.count > 2;
}

struct RepeatabilityOptions {
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// Measures what the pipeline's key `repeatability` describes; see study/repeatability/repeatability_choice.h. The plan
// must have been made with repeatabilityChannels(). Throws InputError for unusable input.
Repeatability measureRepeatability(const Plan& plan, const RepeatabilityOptions& options);

// The result as JSON; the same figures give the same bytes.
std::string repeatabilityJson(const Repeatability& result);

}  // namespace scanmill
