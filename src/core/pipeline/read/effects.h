#pragma once

// Reads the key `effects` of a pipeline, and the lists in the sensors' files to which it may refer:
//
//   effects: [intensity, {range_noise: {sigma_m: 0.01}}]
//   effects: sensor                                        # the list in each sensor's own file
//   effects: [sensor, {footprint: {rays: 61}}, light_paths, {speckle: none}]
//
// The word `sensor` stands for the list in the sensor's file. The other items change this list. If an item's effect is
// in the list already, the item replaces only the keys that it states, or removes the effect if the item's value is
// `none`. Other effects are added. The word `none` alone is ignored, so that a random choice can be between an effect
// and none. The key `label` of an effect is the id or the name of a class.

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "config/fields.h"
#include "config/value.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// The ontology of a pipeline's scenes, read at the first call of find(). Safe to call from several threads.
class EffectClasses {
 public:
  explicit EffectClasses(const Pipeline& pipeline);

  // Returns the ontology; null for a recording without an ontology. Throws InputError.
  const Ontology* find() const;

 private:
  // The file to read the ontology from: at most one is set. If neither is set, the recording's ontology is used.
  std::filesystem::path ontologyFile_, sceneFile_;
  mutable std::once_flag read_;
  mutable std::optional<Ontology> ontology_;
};

// Returns the key `effects` of a pipeline after its key `corruption` is applied; Null if the pipeline has neither key.
// Distributions are still in the result. Throws InputError.
Value writtenEffects(const Value& root);

// True if Pipeline::effectItems contains the word `sensor`: then each sensor has its own effects.
bool takesSensorEffects(const Pipeline& pipeline);

// Sets Pipeline::effectItems and MountedSensor::effects. `written`: the result of writtenEffects(). The pipeline's
// sequences, sensors and ontology must have been read before. Throws InputError.
void readEffects(const Value& written, Pipeline& pipeline);

// Checks the effects in a sensor's file, also if no pipeline uses them. `classes`: null if no ontology is known; then
// labels are not checked. Throws InputError.
void checkSensorEffects(const Value& sensor, const EffectClasses* classes);

// Returns the effects of a sensor. `list`: the value of the key `effects`; Null: no effects. Throws InputError.
Effects readSensorEffects(const Value& list, const EffectClasses& classes, const MountedSensor& sensor);

// Returns `effect` as an item of an effects list. Options in `change` replace or extend the effect's options.
[[nodiscard]] Value withKeysOf(const NamedOptions& effect, const NamedOptions& change);

// Returns the effects list `items` with the word `sensor` replaced by the effects in the sensor's file. Each returned
// item is a name or a map with one key. Throws InputError.
[[nodiscard]] std::vector<Value> sensorEffectItems(const std::vector<Value>& items, const MountedSensor& sensor);

// The key `corruption` of a pipeline: disturbances for testing the robustness of trained networks. A corruption has
// three severities:
//
//   corruption: {fog: heavy}
//
// A corruption is the name of a file in pipelines/corruptions, or the path of another file. The file has a list of
// effects for each severity:
//
//   summary: fog, visibility 500, 150 and 50 m
//   light: [weather: {kind: fog, severity: light}]
//   moderate: [...]
//   heavy: [...]

// Returns the names of the severities in rising order.
const std::vector<std::string>& severities();

// Returns the list `effects` after the corruption is applied to it. An effect of the corruption that is also in the
// list replaces only the keys that the corruption states. The corruption's effect replaces the complete effect if it
// names a kind of weather, or if the list gives `none` or a random choice for the effect. Effects of the corruption
// that are not in the list are appended. `effects` may be Null or the word `sensor`. Throws InputError.
[[nodiscard]] Value withCorruption(const Value& effects, const Value& corruption);

// Returns the names of the corruptions that come with the program, in alphabetical order.
std::vector<std::string> corruptionNames();

// Returns the summary of a corruption in corruptionNames(). Throws InputError for another name.
std::string corruptionSummary(const std::string& name);

}  // namespace scanmill
