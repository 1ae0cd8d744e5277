#pragma once

// Reads sensor files, such as those in pipelines/sensors.
//
//   const std::shared_ptr<const BeamTable> beams = makeBeams(readYaml("pipelines/sensors/vlp_16.yaml"));
//
// docs/keys.md explains the keys of a sensor file, with their units and defaults.

#include <cstdint>
#include <memory>

#include "config/value.h"
#include "sensors/beams.h"

namespace scanmill {

// The number and the time of a sensor file's beams, without building the table, so that a plan with too many beams is
// refused before memory is allocated.
struct SensorSize {
  std::uint64_t rings = 0;
  std::uint64_t columns = 0;  // in a revolution: a turn, or one of its sectors
  double period = 0.1;        // s, duration of a revolution
  std::uint32_t sectors = 1;  // revolutions in a turn, see BeamTable::sectors
};

// Returns the complete map of a sensor: the keys of its preset, if it names one, overridden by the keys of `value`.
// `value` is a sensor of a pipeline, {name:, preset: sensors/os1_128.yaml, mount: {...}, any sensor key}. Each key
// keeps its location in its file. Throws InputError.
[[nodiscard]] Value resolveSensor(const Value& value);

// Both functions read a sensor map from resolveSensor() or from a sensor file. They throw InputError with the
// location, also for more than 8192 rings or 65536 columns.
SensorSize sensorSize(const Value& description);
std::shared_ptr<const BeamTable> makeBeams(const Value& description);

}  // namespace scanmill
