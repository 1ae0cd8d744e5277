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

std::vector<DriveStop> readStops(Fields& fields, double length) {
  constexpr double kApart = 1;  // m
  std::vector<DriveStop> stops;
  const Value* list = fields.find("stops");
  if (list == nullptr) return stops;
  if (!fields.has("acceleration")) {
    throw InputError(list->where, "stops need an acceleration (m/s^2), with which the vehicle brakes and starts");
  }
  if (list->kind != Value::Kind::Sequence) {
    throw InputError(list->where, "stops must be a list such as [{at: 60, wait: 4}]");
  }
  for (const Value& item : list->items) {
    Fields f(item, "stop");
    f.also({"at", "wait"}).finish();
    stops.push_back({f.number("at", {kApart, std::max(kApart, length - kApart)}), f.number("wait", {0, 3600}, 3)});
    if (stops.size() > 1 && stops.back().at < stops[stops.size() - 2].at + kApart) {
      throw InputError(item.where, "stops follow each other along the way, at least 1 m apart");
    }
  }
  return stops;
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

double Trajectory::frameTime(std::uint32_t frame) const {
  return everyMetres_ > 0 ? profile_->timeAt(std::min(frame * everyMetres_, path_->length())) : frame * interval_;
}

Pose Trajectory::pose(std::uint32_t frame, double dt) const {
  if (frame >= frames_) throw Error(fmt::format("frame {} of a trajectory of {} frames", frame, frames_));
  if (path_ == nullptr) return poses_[frame];
  const double time = frameTime(frame) + dt;
  const double distance = profile_->distance(time);
  Pose pose = path_->pose(distance);
  if (!laneChanges_.empty()) {
    // Quintic, so that the wheel is turned smoothly: 10 u^3 - 15 u^4 + 6 u^5.
    double left = 0;
    double slope = 0;
    for (const LaneChange& c : laneChanges_) {
      const double u = std::clamp((distance - c.at) / c.over, 0.0, 1.0);
      left += c.left * u * u * u * (10 + u * (6 * u - 15));
      slope += c.left / c.over * 30 * u * u * (1 - u) * (1 - u);
    }
    pose.translation = pose * Vec3d{0, left, 0};
    pose.rotation = pose.rotation * fromYawPitchRoll(std::atan(slope), 0, 0);
  }
  return pose * sway_.at(time, profile_->speed(time) / speed_);
}

double Trajectory::pathLength() const {
  return path_ ? path_->length() : 0;
}

std::vector<Trajectory::LaneChange> Trajectory::readLaneChanges(const Value& value, double length) {
  if (value.kind != Value::Kind::Sequence) {
    throw InputError(value.where, "lane_changes must be a list such as [{at: 80, left: 3, over: 30}]");
  }
  std::vector<LaneChange> changes;
  for (const Value& item : value.items) {
    Fields f(item, "lane change");
    f.also({"at", "left", "over"}).finish();
    changes.push_back({f.number("at", {0, length}), f.number("left", {-50, 50}), f.number("over", {1, 1e4}, 30)});
  }
  return changes;
}

Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod, const SceneLanes* lanes,
                          std::uint64_t seed) {
  Fields fields(value, "trajectory");
  fields
      .also({"name", "poses", "waypoints", "along", "speed", "acceleration", "stops", "lane_changes", "sway", "every_s",
             "every_m", "frames"})
      .finish();
  Trajectory result;
  result.name_ = fields.text("name", name);
  const double limit =
      fields.has("frames") ? static_cast<double>(fields.integer("frames", 1, Trajectory::kMaxFrames)) : INFINITY;

  if (fields.has("poses")) {
    for (const char* key : {"waypoints", "along"}) {
      if (!fields.has(key)) continue;
      throw InputError(fields.require(key).where, fmt::format("a trajectory has either poses or {}, not both", key));
    }
    for (const char* key : {"speed", "every_m", "acceleration", "stops", "lane_changes", "sway"}) {
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
    throw InputError(value.where,
                     fmt::format("trajectory {} needs one of poses, waypoints and `along`, not several", result.name_));
  }
  const bool turns = along && fields.choice("along", {"lane", "turns"}, "lane") == "turns";
  const Value& way = fields.require(along ? "along" : "waypoints");
  if (along && lanes == nullptr) {
    throw InputError(way.where, "`along` means the lanes of the scene's town; here is none: give waypoints");
  }
  result.path_ = std::make_shared<const Path>(!along ? readWaypoints(way) : turns ? lanes->turns : lanes->lane);
  if (turns) result.turns_ = lanes->turnCount;
  result.speed_ = fields.number("speed", {0, 100});
  if (result.speed_ <= 0) {
    throw InputError(fields.require("speed").where,
                     "speed must be above 0 m/s; for a vehicle that stands still use poses");
  }
  if (fields.has("every_s") && fields.has("every_m")) {
    throw InputError(fields.require("every_m").where, "a frame comes either every_s or every_m, not both");
  }
  const double length = result.path_->length();
  if (const Value* sway = fields.find("sway")) result.sway_ = Sway(*sway, seed);
  if (const Value* changes = fields.find("lane_changes")) {
    result.laneChanges_ = Trajectory::readLaneChanges(*changes, length);
  }
  const std::vector<DriveStop> stops = readStops(fields, length);
  double duration = length / result.speed_;
  if (fields.has("acceleration")) {
    result.profile_.emplace(*result.path_, result.speed_, fields.number("acceleration", {0.01, 20}), stops);
    duration = result.profile_->duration();
    if (fields.has("every_m")) result.everyMetres_ = fields.number("every_m", kStep);
  } else {
    result.profile_.emplace(length, result.speed_);
  }
  result.interval_ = fields.has("every_m") ? fields.number("every_m", kStep) / result.speed_
                                           : fields.number("every_s", kStep, fallbackPeriod);
  if (result.everyMetres_ > 0) duration = length / result.speed_;  // as many frames as at one speed
  result.frames_ = countFrames(duration, result.interval_, length, result.speed_, limit, way.where);
  return result;
}

}  // namespace scanmill
