#pragma once

// Reads the key `effects` of a pipeline, and the lists in the sensors' files that it may stand for:
//
//   effects: [intensity, {range_noise: {sigma_m: 0.01}}]
//   effects: sensor                                        # those of each sensor's own file
//   effects: [sensor, {footprint: {rays: 61}}, light_paths, {speckle: none}]
//
// Beside `sensor`, an item that the sensor's own list has too changes the keys that it names, `none` leaves it out, and
// any other is added. An item `none` is no effect, as a choice among effects may have it. The key `label` of an effect
// is a class, by its id or its name.

#include <mutex>
#include <optional>

#include "config/named_options.h"
#include "config/value.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// The classes of a pipeline's scenes, read once somebody asks. Safe to ask from several threads.
class EffectClasses {
 public:
  explicit EffectClasses(const Pipeline& pipeline);

  // Null: a recording that has no ontology. Throws InputError.
  const Ontology* find() const;

 private:
  std::filesystem::path ontologyFile_, sceneFile_;  // one of them; neither: the recording's own
  mutable std::once_flag read_;
  mutable std::optional<Ontology> ontology_;
};

// Returns the key `effects` of a pipeline with its `corruption` applied; Null where there is neither. What it draws at
// random is not drawn yet. Throws InputError.
Value writtenEffects(const Value& root);

// Returns the items of that list with what is drawn for the first frame of the first sequence, for studies that vary
// them. The word `sensor` stands for the sensors' own. Throws InputError.
std::vector<Value> effectItems(const Pipeline& pipeline);

// Returns true if that list says `sensor`: each sensor has effects of its own then.
bool takesSensorEffects(const Pipeline& pipeline);

// Fills MountedSensor::effects. All else of the pipeline that effects depend on is read already: sequences, sensors,
// ontology. The sensors' own lists are checked whether or not they are used. Throws InputError.
void readEffects(Pipeline& pipeline);

// The effects of a sensor, with `list` as the key `effects`; Null: none. Throws InputError.
Effects readSensorEffects(const Value& list, const EffectClasses& classes, const MountedSensor& sensor);

// An effect with the keys of another of its name in place of its own, as an item of a list.
Value withKeysOf(const NamedOptions& own, const NamedOptions& change);

// The items of such a list with the sensor's own in place of the word `sensor`, as maps of one pair or names. Throws
// InputError.
std::vector<Value> sensorEffectItems(const std::vector<Value>& items, const MountedSensor& sensor);

}  // namespace scanmill
