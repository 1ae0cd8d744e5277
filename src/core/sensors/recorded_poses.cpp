#include "sensors/recorded_poses.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "config/fields.h"
#include "config/waypoints.h"

namespace scanmill {
namespace {

constexpr double kLatest = 1e11;  // s since 1970; a time in ms is later

// Converts from the axes x forward, y left, z up to a camera's axes x right, y down, z forward.
constexpr Mat3 kCameraFromVehicle{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};

std::string formatOf(Fields& f, const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const std::string guess = name.ends_with(".csv") ? "csv" : name.ends_with(".json") ? "nuscenes" : "";
  std::string format = f.choice("format", {"kitti", "tum", "nuscenes", "csv"}, guess);
  if (format.empty()) {
    throw InputError(f.where(), fmt::format("the name {} does not show the format of the poses: give `format: kitti` "
                                            "(12 numbers per line) or `format: tum` (time x y z qx qy qz qw)",
                                            file.string()));
  }
  return format;
}

std::vector<StampedPose> readKitti(Fields& f, const std::filesystem::path& file) {
  std::vector<Affine> cameras = readKittiPoses(file);
  std::vector<double> times;
  if (f.has("times") == f.has("interval")) {
    throw InputError(f.where(),
                     "KITTI's poses have no times: give either `times` (a file with one time in s per line) or "
                     "`interval` (s from pose to pose, 0.1 in KITTI)");
  }
  if (f.has("times")) {
    const std::filesystem::path timesFile = f.path("times");
    times = readTimes(timesFile);
    if (times.size() != cameras.size()) {
      throw InputError({timesFile.string()},
                       fmt::format("has {} times for the {} poses of {}", times.size(), cameras.size(), file.string()));
    }
  } else {
    const double interval = f.number("interval", {1e-6, 1e6});
    for (std::size_t i = 0; i < cameras.size(); ++i) times.push_back(static_cast<double>(i) * interval);
  }
  const auto calib = f.optionalPath("calib");
  const Affine cameraFromOwn = calib ? readKittiCalibration(*calib) : Affine{kCameraFromVehicle, {}};
  const Affine ownFromCamera = inverse(cameraFromOwn);
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Affine own = ownFromCamera * cameras[i] * cameraFromOwn;
    poses.push_back({times[i], {fromMatrix(own.linear), own.translation}});
  }
  return poses;
}

// Moves all poses and rotates them about the vertical, so that the first pose has the position `place` (m) and the
// heading `yaw` (rad).
void startAt(const Vec3d& place, double yaw, std::vector<StampedPose>& poses) {
  const Pose first = poses.front().pose;
  const Quat turn = fromYawPitchRoll(yaw - headingOf(first.rotation), 0, 0);
  const Pose move{turn, place - toMatrix(turn) * first.translation};
  for (StampedPose& p : poses) p.pose = move * p.pose;
}

}  // namespace

RecordedPoses::RecordedPoses(std::vector<StampedPose> poses) : poses_(std::move(poses)) {
  const double first = poses_.front().time;
  for (StampedPose& p : poses_) p.time -= first;
}

Pose RecordedPoses::at(double time) const {
  if (time <= 0) return poses_.front().pose;
  if (time >= duration()) return poses_.back().pose;
  const auto later =
      std::upper_bound(poses_.begin(), poses_.end(), time, [](double t, const StampedPose& p) { return t < p.time; });
  const auto i = static_cast<std::size_t>(later - poses_.begin()) - 1;
  const StampedPose& a = poses_[i];
  const StampedPose& b = poses_[i + 1];
  const double span = b.time - a.time;
  const double u = (time - a.time) / span;
  const auto meanOf = [&](std::size_t k) {  // mean velocity (m/s) from pose k to pose k + 1
    return (poses_[k + 1].pose.translation - poses_[k].pose.translation) * (1 / (poses_[k + 1].time - poses_[k].time));
  };
  // Returns the velocity at pose k on the parabola through this pose and its two neighbours, limited so that the curve
  // between two poses does not overshoot.
  const auto velocity = [&](std::size_t k) {
    if (k == 0 || k + 1 == poses_.size()) return meanOf(k == 0 ? 0 : k - 1);
    const Vec3d before = meanOf(k - 1);
    const Vec3d behind = meanOf(k);
    const double earlier = poses_[k].time - poses_[k - 1].time;
    const double next = poses_[k + 1].time - poses_[k].time;
    const Vec3d v = (before * next + behind * earlier) * (1 / (earlier + next));
    const double most = 3 * std::min(scanmill::length(before), scanmill::length(behind));
    const double own = scanmill::length(v);
    return own > most ? v * (most / own) : v;
  };
  // Cubic Hermite interpolation.
  const Vec3d start = velocity(i) * span;
  const Vec3d end = velocity(i + 1) * span;
  const Vec3d chord = b.pose.translation - a.pose.translation;
  const Vec3d position =
      a.pose.translation + (start + (chord * 3 - start * 2 - end + (start + end - chord * 2) * u) * u) * u;
  return {slerp(a.pose.rotation, b.pose.rotation, u), position};
}

double RecordedPoses::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    sum += scanmill::length(poses_[i].pose.translation - poses_[i - 1].pose.translation);
  }
  return sum;
}

std::vector<double> RecordedPoses::times() const {
  std::vector<double> times;
  for (const StampedPose& p : poses_) times.push_back(p.time);
  return times;
}

std::string RecordedPoses::about() const {
  double gap = 0;
  for (std::size_t i = 1; i < poses_.size(); ++i) gap = std::max(gap, poses_[i].time - poses_[i - 1].time);
  return fmt::format("{} poses in {:.4g} s, {:.4g} m, at most {:.3g} s apart, {:.3g} m/s", poses_.size(), duration(),
                     length(), gap, length() / duration());
}

std::string RecordedPoses::doubt() const {
  constexpr double kFastest = 100;    // m/s
  constexpr double kMoves = 0.5;      // m/s; below this speed the direction of travel is not tested
  constexpr double kMostTilted = 20;  // degrees, largest mean tilt
  constexpr double kMostAskew = 45;   // degrees, largest mean angle between the heading and the direction of travel
  double fastest = 0;
  double when = 0;  // s, time of the fastest step
  double upright = 0;
  double ahead = 0;
  double moved = 0;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    const Vec3d way = poses_[i].pose.translation - poses_[i - 1].pose.translation;
    const double speed = scanmill::length(way) / (poses_[i].time - poses_[i - 1].time);
    const Mat3 axes = toMatrix(poses_[i].pose.rotation);
    if (speed > fastest) when = poses_[i].time;
    fastest = std::max(fastest, speed);
    upright += axes.z.z;
    if (speed < kMoves) continue;
    moved += scanmill::length(way);
    ahead += dot(axes.x, way);
  }
  const auto angle = [](double cosine) { return degrees(std::acos(std::clamp(cosine, -1.0, 1.0))); };
  const double tilt = angle(upright / static_cast<double>(poses_.size() - 1));
  const double askew = moved > 0 ? angle(ahead / moved) : 0;
  if (fastest <= kFastest && tilt <= kMostTilted && askew <= kMostAskew) return {};
  return fmt::format(
      "the vehicle drives at up to {:.4g} m/s (at {:.6g} s), is tilted by {:.0f} degrees on average and heads {:.0f} "
      "degrees off its "
      "way: are times in s, positions in m and angles in degrees (columns yaw_deg, pitch_deg, roll_deg), is the order "
      "of the quaternion right, or are the poses of a camera (`frame: camera`)?",
      fastest, when, tilt, askew);
}

RecordedPoses readRecordedPoses(const Value& value) {
  Fields f(value, "recorded");
  f.also({"file", "format", "times", "interval", "calib", "scene", "frame", "start"}).finish();
  const std::filesystem::path file = f.path("file");
  const std::string format = formatOf(f, file);
  const std::string why = "is not for poses of the format " + format;
  if (format != "kitti") f.refuse({"times", "interval", "calib"}, why);
  if (format != "nuscenes") f.refuse({"scene"}, why);
  if (format != "tum" && format != "csv") f.refuse({"frame"}, why);
  std::vector<StampedPose> poses;
  if (format == "kitti") {
    poses = readKitti(f, file);
  } else if (format == "nuscenes") {
    poses = readNuScenesPoses(file, f.text("scene"));
  } else {
    poses = format == "tum" ? readTumPoses(file) : readPoseTable(file);
    if (f.choice("frame", {"vehicle", "camera"}, "vehicle") == "camera") {
      for (StampedPose& p : poses) p.pose.rotation = p.pose.rotation * fromMatrix(kCameraFromVehicle);
    }
  }
  if (poses.size() < 2) {
    throw InputError({file.string()},
                     fmt::format("has {} poses, but a moving vehicle needs at least two", poses.size()));
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    checkedPosition(poses[i].pose.translation, {file.string(), poses[i].line});
    if (std::fabs(poses[i].time) > kLatest) {
      throw InputError({file.string(), poses[i].line},
                       fmt::format("has the time {:.6g} s: times must be in seconds, or in a .csv table in a column "
                                   "time_ms, time_us or time_ns",
                                   poses[i].time));
    }
    if (i == 0 || poses[i].time > poses[i - 1].time) continue;
    throw InputError(
        {file.string(), poses[i].line},
        fmt::format("pose {} has the time {:.6f} s, which is not after that of the pose before it, {:.6f} s", i + 1,
                    poses[i].time, poses[i - 1].time));
  }
  if (const Value* start = f.find("start")) {
    Fields pose(*start, "start");
    pose.also({"position", "yaw_deg"}).finish();
    const Vec3d wanted = pose.vec3("position", poses.front().pose.translation);
    const double yaw = radians(pose.number("yaw_deg", {-360, 360}, degrees(headingOf(poses.front().pose.rotation))));
    startAt(checkedPosition(wanted, start->where), yaw, poses);
  }
  return RecordedPoses(std::move(poses));
}

}  // namespace scanmill
