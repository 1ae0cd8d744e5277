#pragma once

// A shot: one revolution of one sensor at one time. It has one pose of the sensor or, if the sensor moves, several
// poses, and the address of the shot's random numbers.
//
//   Shot shot;  // the sensor stands still, 1.9 m above the world's origin
//   shot.beams = beams;
//   shot.worldFromSensor = {Pose{.rotation = {}, .translation = {0, 0, 1.9}}};

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"
#include "scene/placements.h"
#include "sensors/beams.h"

namespace scanmill {

class Trajectory;

struct Shot {
  std::uint64_t seed = 0;    // seed, scene, frame and sensor are the address of the shot's random numbers
  std::uint32_t scene = 0;   // index of the sequence in the pipeline
  std::uint32_t frame = 0;   // index in the sequence
  std::uint32_t sensor = 0;  // index of the sensor on the vehicle
  // Index of the revolution within this sensor and sample, below kMostRevolutions. A sensor that turns faster than the
  // slowest sensor has several revolutions in a sample.
  std::uint32_t revolution = 0;
  std::string sensorName{};
  std::string sample{};  // key of the sample; file names of the shot begin with it
  double time = 0;       // s since the start of the sequence, at column 0
  double duration = 0;   // s, time in which the scene's objects move; 0: objects keep their pose at `time`
  // Time (s) from `time` to the sensor's next revolution in the dataset. For a revolution that begins with its frame,
  // this is the time to the sequence's next frame; in the last frame, the time since the previous frame; in a single
  // frame, the sensor's period.
  double untilNext = 0;
  std::shared_ptr<const BeamTable> beams{};

  // The sensor's pose at the start of each step of the revolution; one pose: the sensor stands still during the
  // revolution. A column belongs to the step column * steps / columns, rounded down; steps need not divide the number
  // of columns.
  std::vector<Pose> worldFromSensor{};

  // The velocity over ground (m/s, world axes) of the sensor's origin in each step. Empty: the sensor stands still.
  std::vector<Vec3d> sensorVelocity{};

  // The frame in which points are given. False: each point in the sensor's frame at the step that fired it, as sensors
  // report points. True: all points in the sensor's frame at the start of the revolution.
  bool deskew = false;

  // Distance (m) along each ray of `beams` beyond which the ray's hits do not matter, for example because the ego
  // vehicle blocks the ray; may be infinite. Empty: all hits matter. Methods may ignore the array, which must outlive
  // the shot.
  std::span<const float> blockedBeyond{};

  // Poses of objects in this shot that replace the poses of the scene; null: all objects have the scene's poses. The
  // scene must be `placeable`.
  std::shared_ptr<const Placements> placed{};

  // Largest number of a sensor's revolutions in a sample: the address of random numbers has 8 bits for the index.
  static constexpr std::uint32_t kMostRevolutions = 256;
  // Returns frame and revolution as one number, which is part of the address of the shot's random numbers. Frames are
  // at most Trajectory::kMaxFrames and leave the upper 8 bits free.
  std::uint32_t randomFrame() const { return frame | revolution << 24; }

  std::size_t stepOf(std::uint32_t column) const {
    const std::uint32_t rays = beams->raysPerBeam;
    return static_cast<std::size_t>(std::uint64_t{column / rays} * worldFromSensor.size() / (beams->columns / rays));
  }
  // Returns the transform from the sensor's frame at a step to its frame at the start of the revolution.
  Affine startFromStep(std::size_t step) const;
};

// The number of sensor poses in a revolution: one pose, one pose per column, or Motion::steps poses.
enum class MotionKind { None, PerColumn, Steps };

struct Motion {
  MotionKind kind = MotionKind::None;
  std::uint32_t steps = 1;  // number of poses in a revolution; used only by MotionKind::Steps
  bool deskew = false;
  Location where;
};

// Reads a sensor's motion: `none`, `per_column`, or a map such as {steps: 360, deskew: false} or {steps: per_column,
// deskew: true}. A null pointer means `none`. Throws InputError for anything else.
Motion readMotion(const Value* value);

// Returns the shot of a revolution: its poses, velocity, times, deskew and frame, and the beams of `table` at its time
// (see beamsAt()). The caller sets the names and the other parts of the address of the random numbers. `begin`: time
// (s) from the frame's start to the revolution's start; may be negative. Throws InputError if the motion has more steps
// than the sensor has columns.
Shot makeShot(const std::shared_ptr<const BeamTable>& table, const Trajectory& trajectory, std::uint32_t frame,
              const Pose& vehicleFromSensor, const Motion& motion, double begin = 0);

}  // namespace scanmill
