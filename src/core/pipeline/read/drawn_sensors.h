#pragma once

// Random sensors, and sensors with random mounts or effects: the pipeline gives distributions, from which values are
// sampled for each sequence or each frame (see config/distribution.h).

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/distribution.h"
#include "config/value.h"
#include "pipeline/read/effects.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// The mounts and effects of the sensors in one frame.
struct SensorDraw {
  std::vector<Pose> mounts;  // pose of each sensor in the vehicle's frame (vehicleFromSensor)
  std::vector<std::shared_ptr<const Effects>> effects;  // list of effects of each sensor
  std::vector<bool> scans;                              // false: another sensor of the random choice scans
  std::vector<DrawnValue> draws;
};

class DrawnSensors {
 public:
  // The YAML values of mounts and effects before sampling. A mount of the kind Null means the vehicle's origin.
  struct Written {
    Value effects;              // the pipeline's key `effects`; Null: no effects
    std::vector<Value> mounts;  // mount of each sensor
    // MountedSensor::description of each sensor. Its key `effects` may contain distributions.
    std::vector<Value> descriptions;
    std::vector<std::string> keys;         // MountedSensor::key of each sensor
    std::map<std::string, Value> choices;  // by MountedSensor::choice: the distribution of the sensors' names
  };

  // True if any of the values contains a distribution.
  static bool draws(const Written& written);

  // Checks the mounts and effects of all cases(). Everything in `pipeline` that effects depend on must have been read
  // before. Throws InputError.
  DrawnSensors(Written written, const Pipeline& pipeline);

  bool drawsMounts() const { return drawsMounts_; }
  bool drawsPerFrame() const { return drawsPerFrame_; }

  // Samples the mounts and effects for a frame of a sequence. `pipeline` provides only the sensors' names and the seed.
  // Safe to call from several threads. Throws InputError.
  SensorDraw draw(const Pipeline& pipeline, std::size_t sequence, std::uint32_t frame) const;

  // Returns test cases: together they contain both ends of each distribution and each item of each random choice.
  const std::vector<SensorDraw>& cases() const { return cases_; }

  // Returns items such as "random for each sequence: effects.1.speckle.looks {uniform: [1, 8]}", one per distribution.
  std::vector<ModelledItem> items() const;

 private:
  template <class Sampled>
  SensorDraw settingsWith(const Pipeline& pipeline, const Sampled& sampled) const;
  // Calls visit(key, value) for the mounts, the sensors' effects and the pipeline's effects.
  template <class Visit>
  void forEachKey(const Visit& visit) const;
  void checkCases() const;

  Written written_;
  std::shared_ptr<const EffectClasses> classes_;
  std::vector<PlaceInSplit> places_;  // by sequence: place of its first frame in its split
  bool drawsMounts_ = false;
  bool drawsPerFrame_ = false;
  std::vector<SensorDraw> cases_;
};

}  // namespace scanmill
