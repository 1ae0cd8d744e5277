#pragma once

// What a pipeline draws of its sensors, anew for each sequence or each frame (see config/distribution.h): where they
// are mounted, and their effects.

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

// How the sensors stand and what runs on their scans in one frame.
struct SensorDraw {
  std::vector<Pose> mounts;                             // vehicleFromSensor
  std::vector<std::shared_ptr<const Effects>> effects;  // of each sensor
  std::vector<DrawnValue> draws;
};

class DrawnSensors {
 public:
  // What the file says. A mount of the kind Null is the vehicle's origin.
  struct Written {
    Value effects;                    // of the pipeline; Null where it has none
    std::vector<Value> mounts;        // of each sensor
    std::vector<Value> descriptions;  // likewise, of which `effects` may hold distributions
  };

  // Whether anything of it is to be drawn.
  static bool draws(const Written& written);

  // Checks the ends of all that may be drawn. All else of the pipeline that effects depend on is read already. Throws
  // InputError.
  DrawnSensors(Written written, const Pipeline& pipeline);

  bool drawsMounts() const { return drawsMounts_; }
  bool drawsPerFrame() const { return drawsPerFrame_; }

  // Of a frame of a sequence of this pipeline, of which the sensors' names and the seed are looked at. Safe to call
  // from several threads. Throws InputError.
  SensorDraw draw(const Pipeline& pipeline, std::size_t sequence, std::uint32_t frame) const;

  // With every end of what may be drawn at least once.
  const std::vector<SensorDraw>& cases() const { return cases_; }

  // One line for each key, such as "drawn for each sequence: effects.1.speckle.looks {uniform: [1, 8]}".
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
