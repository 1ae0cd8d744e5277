#include "sensors/shot.h"

#include <fmt/format.h>

#include <utility>

#include "config/fields.h"
#include "sensors/trajectory.h"

namespace scanmill {

Motion readMotion(const Value* value) {
  Motion motion;
  if (value == nullptr) return motion;
  motion.where = value->where;
  if (value->kind == Value::Kind::Scalar && value->text == "none") return motion;
  if (value->kind == Value::Kind::Scalar && value->text == "per_column") {
    motion.kind = MotionKind::PerColumn;
    return motion;
  }
  if (value->kind != Value::Kind::Map) {
    throw InputError(value->where,
                     fmt::format("motion must be none, per_column or {{steps: 360, deskew: false}}{}",
                                 value->kind == Value::Kind::Scalar ? suggestion(value->text, {"none", "per_column"})
                                                                    : std::string()));
  }
  Fields fields(*value, "motion");
  const Value& steps = fields.require("steps");
  if (steps.kind == Value::Kind::Scalar && steps.text == "per_column") {
    motion.kind = MotionKind::PerColumn;
  } else {
    motion.kind = MotionKind::Steps;
    motion.steps = static_cast<std::uint32_t>(readInteger(steps, "steps", 1, 65536));
  }
  motion.deskew = fields.boolean("deskew", false);
  fields.finish();
  return motion;
}

Shot makeShot(const std::shared_ptr<const BeamTable>& table, const Trajectory& trajectory, std::uint32_t frame,
              const Pose& vehicleFromSensor, const Motion& motion, double begin) {
  std::shared_ptr<const BeamTable> beams = beamsAt(table, trajectory.frameTime(frame) + begin);
  std::uint64_t steps = 1;
  if (motion.kind == MotionKind::PerColumn) steps = beams->columns;
  if (motion.kind == MotionKind::Steps) steps = motion.steps;
  if (steps > beams->columns) {
    throw InputError(
        motion.where,
        fmt::format(
            "motion has {} steps per revolution, but the sensor {} has {} columns: give at most {}, or per_column",
            steps, beams->model, beams->columns, beams->columns));
  }
  const double duration = motion.kind == MotionKind::None ? 0 : beams->columnPeriod() * beams->columns;
  // One pose is enough for a vehicle that stands still.
  if (trajectory.still()) steps = 1;

  Shot shot;
  shot.frame = frame;
  shot.time = trajectory.frameTime(frame) + begin;
  shot.duration = duration;
  double interval = beams->period;  // s, from frame to frame
  if (trajectory.frames() > 1) {
    const std::uint32_t from = std::min(frame, trajectory.frames() - 2);
    interval = trajectory.frameTime(from + 1) - trajectory.frameTime(from);
  }
  shot.untilNext = interval - begin;
  shot.deskew = motion.deskew;
  shot.worldFromSensor.reserve(steps);
  constexpr double kMoment = 1e-3;  // s, time over which velocities are computed
  for (std::uint64_t step = 0; step < steps; ++step) {
    // The first column of the step, by the rule at Shot::worldFromSensor.
    const auto column = static_cast<std::uint32_t>((step * beams->columns + steps - 1) / steps);
    const double time = begin + beams->columnTime(column);
    shot.worldFromSensor.push_back(trajectory.pose(frame, time) * vehicleFromSensor);
    if (trajectory.still()) continue;
    const Pose soon = trajectory.pose(frame, time + kMoment) * vehicleFromSensor;
    const Vec3d moved = soon.translation - shot.worldFromSensor.back().translation;
    shot.sensorVelocity.push_back(moved * (1 / kMoment));
  }
  shot.beams = std::move(beams);
  return shot;
}

}  // namespace scanmill
