#pragma once

// Reads the key `effects` of a pipeline, and the lists in the sensors' files that it may stand for:
//
//   effects: [intensity, {range_noise: {sigma_m: 0.01}}]
//   effects: sensor                                        # those of each sensor's own file
//   effects: [sensor, {footprint: {rays: 61}}, light_paths, {speckle: none}]
//
// Beside `sensor`, an item that the sensor's own list has too changes the keys that it names, `none` leaves it out, and
// any other is added. The key `label` of an effect is a class, by its id or its name.

#include "config/fields.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// Fills effectItems, effects and effectEntries, or the sensors' own where the list says `sensor`. All else of the
// pipeline that effects depend on is read already: sequences, sensors, ontology. The sensors' own lists are checked
// whether or not they are used. Throws InputError.
void readEffects(Fields& fields, Pipeline& pipeline);

// The effects of one of the pipeline's sensors, with `list` as the key `effects`. Throws InputError.
SensorEffects readSensorEffects(const Value& list, const Pipeline& pipeline, const MountedSensor& sensor);

// The items of such a list with the sensor's own in place of the word `sensor`, as maps of one pair or names. Throws
// InputError.
std::vector<Value> sensorEffectItems(const std::vector<Value>& items, const MountedSensor& sensor);

}  // namespace scanmill
