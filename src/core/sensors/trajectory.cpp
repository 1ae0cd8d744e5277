#include "sensors/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/path.h"
#include "config/fields.h"
#include "config/waypoints.h"

namespace scanmill {

namespace {

constexpr Range kStep{1e-9, 1e9};  // s or m

std::vector<Pose> readPoses(const Value& value) {
  if (value.kind != Value::Kind::Sequence || value.items.empty()) {
    throw InputError(value.where, "poses must be a list such as [{position: [0, 0, 2], yaw_deg: 90}]");
  }
  std::vector<Pose> poses;
  poses.reserve(value.items.size());
  for (const Value& item : value.items) {
    Fields fields(item, "pose");
    poses.push_back(fields.pose());
    fields.finish();
    checkedPosition(poses.back().translation, item.where);
  }
  return poses;
}

// Frames from the start of the path to its end, or the limit where that comes first.
std::uint32_t countFrames(double duration, double interval, double pathLength, double speed, double limit,
                          const Location& where) {
  // A frame that falls on the end of the path counts, whatever the rounding.
  const double count = std::min(std::floor(duration / interval * (1 + 1e-12) + 1e-9) + 1, limit);
  if (count > Trajectory::kMaxFrames) {
    throw InputError(where, fmt::format("{:.6g} m of path / {:.6g} m/s / {:.6g} s a frame = {:.6g} frames, more than "
                                        "{}; set every_s, every_m, speed or frames",
                                        pathLength, speed, interval, count, Trajectory::kMaxFrames));
  }
  return static_cast<std::uint32_t>(count);
}

}  // namespace

Pose Trajectory::pose(std::uint32_t frame, double dt) const {
  if (frame >= frames_) throw Error(fmt::format("frame {} of a trajectory of {} frames", frame, frames_));
  return path_ ? path_->pose(speed_ * (frameTime(frame) + dt)) : poses_[frame];
}

double Trajectory::pathLength() const {
  return path_ ? path_->length() : 0;
}

Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod,
                          const std::vector<Vec3d>* lane) {
  Fields fields(value, "trajectory");
  fields.also({"name", "poses", "waypoints", "along", "speed", "every_s", "every_m", "frames"}).finish();
  Trajectory result;
  result.name_ = fields.text("name", name);
  const double limit =
      fields.has("frames") ? static_cast<double>(fields.integer("frames", 1, Trajectory::kMaxFrames)) : INFINITY;

  if (fields.has("poses")) {
    for (const char* key : {"waypoints", "along"}) {
      if (!fields.has(key)) continue;
      throw InputError(fields.require(key).where, fmt::format("a trajectory has either poses or {}, not both", key));
    }
    for (const char* key : {"speed", "every_m"}) {
      if (const Value* moving = fields.find(key)) {
        throw InputError(moving->where, fmt::format("{} is for waypoints: the vehicle stands still in each of `poses`, "
                                                    "which are every_s apart",
                                                    key));
      }
    }
    result.poses_ = readPoses(fields.require("poses"));
    result.interval_ = fields.number("every_s", kStep, fallbackPeriod);
    result.frames_ = static_cast<std::uint32_t>(std::min(static_cast<double>(result.poses_.size()), limit));
    return result;
  }

  const bool along = fields.has("along");
  if (along == fields.has("waypoints")) {
    throw InputError(value.where, fmt::format("trajectory {} needs poses, waypoints or `along: lane`, and one of them",
                                              result.name_));
  }
  if (along) fields.choice("along", {"lane"}, "lane");
  const Value& way = fields.require(along ? "along" : "waypoints");
  if (along && lane == nullptr) {
    throw InputError(way.where, "`along: lane` is the lane of a scene's town; here is no scene: give waypoints");
  }
  result.path_ = std::make_shared<const Path>(along ? *lane : readWaypoints(way));
  result.speed_ = fields.number("speed", {0, 100});
  if (result.speed_ <= 0) {
    throw InputError(fields.require("speed").where,
                     "speed must be above 0 m/s; for a vehicle that stands still use poses");
  }
  if (fields.has("every_s") && fields.has("every_m")) {
    throw InputError(fields.require("every_m").where, "a frame comes either every_s or every_m, not both");
  }
  result.interval_ = fields.has("every_m") ? fields.number("every_m", kStep) / result.speed_
                                           : fields.number("every_s", kStep, fallbackPeriod);
  const double length = result.path_->length();
  result.frames_ = countFrames(length / result.speed_, result.interval_, length, result.speed_, limit, way.where);
  return result;
}

}  // namespace scanmill
