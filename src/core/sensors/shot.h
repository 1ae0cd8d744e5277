#pragma once

// A shot: one revolution of one sensor at one time, from one pose or several if it moves, with the address of its
// random numbers.
//
//   Shot still;  // a sensor that stands 1.9 m above the world's origin
//   still.beams = beams;
//   still.worldFromSensor = {Pose{.rotation = {}, .translation = {0, 0, 1.9}}};

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
  std::uint64_t seed = 0;    // with scene, frame and sensor the address of its random numbers
  std::uint32_t scene = 0;   // index of the sequence in the pipeline
  std::uint32_t frame = 0;   // index in the sequence
  std::uint32_t sensor = 0;  // index on the vehicle
  std::string sensorName;
  std::string sample;   // key of the sample, which names the shot's files
  double time = 0;      // s since the start of the sequence, of column 0
  double duration = 0;  // s, during which the scene's objects move; 0: they stay where they are at `time`
  // s from `time` to the sequence's next frame. The last frame repeats the interval before it; a single frame has the
  // sensor's period.
  double untilNext = 0;
  std::shared_ptr<const BeamTable> beams;

  // The pose at the start of each step of the revolution. With one entry the sensor stands still during the revolution.
  // A column belongs to the step column * steps / columns, rounded down, whether or not the steps divide the columns.
  std::vector<Pose> worldFromSensor;

  // The frame in which points are given. False: the sensor's at the step that fired them, as sensors report them. True:
  // the sensor's at the start of the revolution.
  bool deskew = false;

  std::size_t stepOf(std::uint32_t column) const {
    const std::uint32_t rays = beams->raysPerBeam;
    return static_cast<std::size_t>(std::uint64_t{column / rays} * worldFromSensor.size() / (beams->columns / rays));
  }
};

// The number of poses in a revolution: one, one per column, or a number of steps.
enum class MotionKind { None, PerColumn, Steps };

struct Motion {
  MotionKind kind = MotionKind::None;
  std::uint32_t steps = 1;  // for MotionKind::Steps
  bool deskew = false;
  Location where;
};

// Reads none, per_column, {steps: 360, deskew: false} or {steps: per_column, deskew: true}. A null pointer gives none.
// Throws InputError.
Motion readMotion(const Value* value);

// Returns a shot with its poses, time, beams (those of the table at its time: beamsAt()), frame and deskew; the caller
// sets the names and the rest of the address of its random numbers. Throws InputError if the motion has more steps than
// the sensor has columns.
Shot makeShot(const std::shared_ptr<const BeamTable>& table, const Trajectory& trajectory, std::uint32_t frame,
              const Pose& vehicleFromSensor, const Motion& motion);

}  // namespace scanmill
