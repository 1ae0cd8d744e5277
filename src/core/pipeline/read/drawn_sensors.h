#pragma once

// Sensors whose mounts or effects a pipeline draws at random, anew for each sequence or each frame (see
// config/distribution.h).

#include <cstddef>
#include <cstdint>
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
  std::vector<Pose> mounts;                             // vehicleFromSensor
  std::vector<std::shared_ptr<const Effects>> effects;  // one list per sensor
  std::vector<DrawnValue> draws;
};

class DrawnSensors {
 public:
  // The values of the file, before anything is drawn at random. A mount of the kind Null is the vehicle's origin.
  struct Written {
    Value effects;                    // the effects of the pipeline; Null: none
    std::vector<Value> mounts;        // one per sensor
    std::vector<Value> descriptions;  // one per sensor; their key `effects` may hold distributions
  };

  // True if any of the values holds a distribution.
  static bool draws(const Written& written);

  // Checks all cases (see cases()). The parts of the pipeline that effects depend on must have been read. Throws
  // InputError.
  DrawnSensors(Written written, const Pipeline& pipeline);

  bool drawsMounts() const { return drawsMounts_; }
  bool drawsPerFrame() const { return drawsPerFrame_; }

  // Draws the mounts and effects for a frame of a sequence. Of the pipeline, only the sensors' names and the seed are
  // used. Safe to call from several threads. Throws InputError.
  SensorDraw draw(const Pipeline& pipeline, std::size_t sequence, std::uint32_t frame) const;

  // Returns sets of values in which both ends of each distribution, and each item of each choice, occur at least once.
  const std::vector<SensorDraw>& cases() const { return cases_; }

  // Returns a line for each distribution, such as "drawn for each sequence: effects.1.speckle.looks {uniform: [1, 8]}".
  std::vector<std::string> lines() const;

 private:
  template <class Change>
  SensorDraw made(const Pipeline& pipeline, const Change& change) const;
  template <class Visit>
  void forEachKey(const Visit& visit) const;
  void checkCases() const;

  Written written_;
  std::shared_ptr<const EffectClasses> classes_;
  bool drawsMounts_ = false;
  bool drawsPerFrame_ = false;
  std::vector<SensorDraw> cases_;
};

}  // namespace scanmill
