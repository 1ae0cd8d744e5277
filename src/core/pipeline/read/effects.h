#pragma once

// Reads the key `effects` of a pipeline, and the lists in the sensors' files to which it may refer:
//
//   effects: [intensity, {range_noise: {sigma_m: 0.01}}]
//   effects: sensor                                        # the list in each sensor's own file
//   effects: [sensor, {footprint: {rays: 61}}, light_paths, {speckle: none}]
//
// Beside the word `sensor`, an effect that the sensor's own list has too changes the keys that it names, or removes the
// sensor's effect if its value is `none`; any other effect is added. An item that is only the word `none` adds nothing,
// so that a random choice among effects can be no effect. The key `label` of an effect is a class, by its id or name.

#include <mutex>
#include <optional>

#include "config/named_options.h"
#include "config/value.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// The classes of a pipeline's scenes, read at the first call of find(). Safe to call from several threads.
class EffectClasses {
 public:
  explicit EffectClasses(const Pipeline& pipeline);

  // Returns null for a recording without an ontology. Throws InputError.
  const Ontology* find() const;

 private:
  std::filesystem::path ontologyFile_, sceneFile_;  // at most one is set; neither: the recording's ontology is used
  mutable std::once_flag read_;
  mutable std::optional<Ontology> ontology_;
};

// Returns the key `effects` of a pipeline with its `corruption` applied; Null if it has neither. Distributions are not
// replaced by random values yet. Throws InputError.
Value writtenEffects(const Value& root);

// True if an item of Pipeline::effectItems is the word `sensor`: each sensor then has effects of its own.
bool takesSensorEffects(const Pipeline& pipeline);

// Fills Pipeline::effectItems and MountedSensor::effects. `written`: as writtenEffects() returns it. The pipeline's
// sequences, sensors and ontology must have been read before. The sensors' own lists are checked whether or not they
// are used. Throws InputError.
void readEffects(const Value& written, Pipeline& pipeline);

// Returns the effects of a sensor. `list`: the value of the key `effects`; Null: no effects. Throws InputError.
Effects readSensorEffects(const Value& list, const EffectClasses& classes, const MountedSensor& sensor);

// Returns the effect `own` as an item of a list, with the keys of `change` added to its own or in place of them.
Value withKeysOf(const NamedOptions& own, const NamedOptions& change);

// Returns the items of a list `effects` with the sensor's own effects in place of the word `sensor`. Each item is a
// name or a map of one pair. Throws InputError.
std::vector<Value> sensorEffectItems(const std::vector<Value>& items, const MountedSensor& sensor);

}  // namespace scanmill
