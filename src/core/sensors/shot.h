#pragma once

// One sensor, at one pose or a moving one, at one time, with the address of its randomness.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"
#include "sensors/beams.h"
#include "sensors/trajectory.h"

namespace scanmill {

struct Shot {
  std::uint64_t seed = 0;    // address of its randomness: seed, scene, frame, sensor
  std::uint32_t scene = 0;   // index of the sequence in the pipeline
  std::uint32_t frame = 0;   // in the sequence
  std::uint32_t sensor = 0;  // on the vehicle
  std::string sensorName;
  std::string sample;  // the sample's key: names the files that are kept of the shot
  double time = 0;     // s since the start of the sequence, of column 0
  std::shared_ptr<const BeamTable> beams;

  // Pose at the start of each step of the turn. One entry: the sensor stands still during the turn. A column belongs to
  // step column * steps / columns, so every column has one, whether or not the steps divide the columns.
  std::vector<Pose> worldFromSensor;

  // Points are given in the frame of the step that fired them (false: as the sensor reports them) or in the frame of
  // the turn's start (true).
  bool deskew = false;

  std::size_t stepOf(std::uint32_t column) const {
    return static_cast<std::size_t>(std::uint64_t{column} * worldFromSensor.size() / beams->columns);
  }
};

// How a turn follows the vehicle.
enum class MotionKind { None, PerColumn, Steps };

struct Motion {
  MotionKind kind = MotionKind::None;
  std::uint32_t steps = 1;  // Steps only
  bool deskew = false;
  Location where;
};

// YAML: none | per_column | {steps: 360, deskew: false} | {steps: per_column, deskew: true}; null gives none.
Motion readMotion(const Value* value);

// The poses, time, beams, frame and deskew of a shot; its names and address of randomness are left to the caller.
// Throws InputError where the motion has more steps than the sensor has columns.
Shot makeShot(std::shared_ptr<const BeamTable> beams, const Trajectory& trajectory, std::uint32_t frame,
              const Pose& vehicleFromSensor, const Motion& motion);

}  // namespace scanmill
