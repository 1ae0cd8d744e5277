#include "sensors/shot.h"

#include <fmt/format.h>

#include "config/fields.h"
#include "sensors/trajectory.h"

namespace scanmill {

Affine Shot::startFromStep(std::size_t step) const {
  if (step == 0) return {};
  const Pose& worldFromStart = worldFromSensor[0];
  const Pose& worldFromStep = worldFromSensor[step];
  const Mat3 startFromWorld = transposed(toMatrix(worldFromStart.rotation));
  // The large world coordinates are subtracted first, which keeps the precision.
  return {startFromWorld * toMatrix(worldFromStep.rotation),
          startFromWorld * (worldFromStep.translation - worldFromStart.translation)};
}

Motion readMotion(const Value* value) {
  if (value == nullptr) return {};
  Motion motion{.where = value->where};
  if (value->kind == Value::Kind::Scalar && value->text == "none") return motion;
  if (value->kind == Value::Kind::Scalar && value->text == "per_column") {
    motion.kind = MotionKind::PerColumn;
    return motion;
  }
  if (value->kind != Value::Kind::Map) {
    throw InputError(
        value->where, "motion must be none, per_column or {{steps: 360, deskew: false}}{}",
        value->kind == Value::Kind::Scalar ? suggestion(value->text, {"none", "per_column"}) : std::string());
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
  Shot shot;
  shot.frame = frame;
  shot.time = trajectory.frameTime(frame) + begin;
  shot.beams = beamsAt(table, shot.time);
  shot.deskew = motion.deskew;
  const BeamTable* const beams = shot.beams.get();
  std::uint64_t steps = 1;
  if (motion.kind == MotionKind::PerColumn) steps = beams->columns;
  if (motion.kind == MotionKind::Steps) steps = motion.steps;
  if (steps > beams->columns) {
    throw InputError(
        motion.where,
        "motion has {} steps per revolution, but the sensor {} has {} columns: give at most {}, or per_column", steps,
        beams->model, beams->columns, beams->columns);
  }
  if (motion.kind != MotionKind::None) shot.duration = beams->columnPeriod() * beams->columns;
  double interval = beams->period;  // s, from frame to frame
  if (trajectory.frames() > 1) {
    const std::uint32_t from = std::min(frame, trajectory.frames() - 2);
    interval = trajectory.frameTime(from + 1) - trajectory.frameTime(from);
  }
  shot.untilNext = interval - begin;

  if (trajectory.still()) steps = 1;  // one pose is enough for a vehicle that stands still
  shot.worldFromSensor.reserve(steps);
  constexpr double kVelocityTime = 1e-3;  // s, time over which velocities are computed
  for (std::uint64_t step = 0; step < steps; ++step) {
    // The first column of the step, by the rule at Shot::worldFromSensor.
    const auto column = static_cast<std::uint32_t>((step * beams->columns + steps - 1) / steps);
    const double time = begin + beams->columnTime(column);
    shot.worldFromSensor.push_back(trajectory.pose(frame, time) * vehicleFromSensor);
    if (trajectory.still()) continue;
    const Pose laterPose = trajectory.pose(frame, time + kVelocityTime) * vehicleFromSensor;
    const Vec3d displacement = laterPose.translation - shot.worldFromSensor.back().translation;
    shot.sensorVelocity.push_back(displacement * (1 / kVelocityTime));
  }
  return shot;
}

}  // namespace scanmill
