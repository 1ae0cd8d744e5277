#pragma once

// Measures how well repeated scans of an object agree, by the ICP protocol of the paper "LiDAR-GEIL: LiDAR GPU
// Exploitation in Lightsimulations" (its Figures 10, 11 and 13): the object is scanned several times from each pose
// with different noise, the scans are cropped to the object, one scan is registered to the other, and the fitness is
// taken.

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "evaluate/registration.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// Number of points on the object in the scans from one pose with one noise level.
struct PointCount {
  double mean = 0;
  std::uint64_t least = 0;
  std::uint64_t most = 0;
};

// The fitness of all ordered pairs of scans with different seeds, for one noise level of the sources and one of the
// targets: mean squared distances (m²) from the points of the source to the nearest points of the target.
struct LevelFitness {
  FitnessSpread registered;  // after ICP; only pairs that ICP could move: it needs three points in each scan
  FitnessSpread unmoved;     // without ICP, of the pairs that have points: both scans have the same pose
  std::uint64_t pairs = 0;   // all pairs
};

// Measurements from one pose of the sensor.
struct RepeatedPlace {
  std::uint32_t frame = 0;
  std::string object;
  double distance = 0;                // m, from the sensor to the object's box
  std::vector<PointCount> points;     // one per noise level
  std::vector<LevelFitness> fitness;  // [source level * levels + target level]
};

struct RepeatedView {
  std::size_t method = 0;  // index into Repeatability::methods
  // "small_box front": the scene, its seed if there are several, the trajectory, and the sensor if there are several.
  std::string name;
  std::string sensor;  // "lidar0 (OS1-128, 128 x 1024 beams)"
  std::vector<RepeatedPlace> places;
};

struct Repeatability {
  static constexpr int kSchemaVersion = 1;
  std::string programVersion;
  std::string pipelineName;
  std::string pipelineText;  // as Pipeline::text: with the overrides as comments
  std::uint64_t seed = 0;    // seed of the first scan; the other scans have the seeds that follow
  std::uint32_t scans = 0;   // from each pose
  double margin = 0;         // m; points farther from the object's box are cropped away
  IcpOptions icp;
  std::vector<std::string> methods;  // the names of the settings
  std::vector<std::string> levels;   // the names of the noise levels
  std::size_t reference = 0;         // index into levels: the level of the first charts
  std::vector<RepeatedView> views;
  std::vector<std::string> warnings;  // sentences about figures that are not meaningful

  std::vector<std::string> objects() const;  // names of the objects that the sensors look at, each once
  std::vector<std::string> sensors() const;  // RepeatedView::sensor of the views, each once
  const LevelFitness& at(const RepeatedPlace& place, std::size_t source, std::size_t target) const {
    return place.fitness[source * levels.size() + target];
  }
};

// True if the spread has a meaningful deviation: two pairs are the same two scans in both directions.
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

// Returns the result as JSON; the same figures give the same bytes.
std::string repeatabilityJson(const Repeatability& result);

}  // namespace scanmill
