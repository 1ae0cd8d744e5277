#include "sensors/recorded_poses.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "config/fields.h"

namespace scanmill {
namespace {

constexpr double kLatest = 1e11;  // s since 1970; larger numbers are times in ms

// Converts from the axes x forward, y left, z up to a camera's axes x right, y down, z forward.
constexpr Mat3 kCameraFromVehicle{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};

// Returns the value of the key `format` or, in its absence, the format that the file's suffix shows.
std::string formatOf(Fields& f, const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const std::string guess = name.ends_with(".csv") ? "csv" : name.ends_with(".json") ? "nuscenes" : "";
  std::string format = f.choice("format", {"kitti", "tum", "nuscenes", "csv"}, guess);
  if (format.empty()) {
    throw InputError(f.where(),
                     "the name {} does not show the format of the poses: give `format: kitti` "
                     "(12 numbers per line) or `format: tum` (time x y z qx qy qz qw)",
                     file.string());
  }
  return format;
}

// Returns the poses of the vehicle or, with `calib`, of the scanner. KITTI's poses are poses of the left camera, in the
// axes of the camera's first frame; here they are converted to the axes of the vehicle's or the scanner's first frame.
std::vector<StampedPose> readKitti(Fields& f, const std::filesystem::path& file) {
  const std::vector<Affine> cameras = readKittiPoses(file);
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
      throw InputError({timesFile.string()}, "has {} times for the {} poses of {}", times.size(), cameras.size(),
                       file.string());
    }
  } else {
    const double interval = f.number("interval", {1e-6, 1e6});
    for (std::size_t i = 0; i < cameras.size(); ++i) times.push_back(static_cast<double>(i) * interval);
  }
  const auto calib = f.optionalPath("calib");
  const Affine cameraFromVehicle = calib ? readKittiCalibration(*calib) : Affine{kCameraFromVehicle, {}};
  const Affine vehicleFromCamera = inverse(cameraFromVehicle);
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Affine vehicle = vehicleFromCamera * cameras[i] * cameraFromVehicle;
    poses.push_back({times[i], {fromMatrix(vehicle.linear), vehicle.translation}});
  }
  return poses;
}

// Moves all poses and rotates them about the vertical: the first pose gets `position` (m) and the heading `yaw` (rad).
void startAt(const Vec3d& position, double yaw, std::vector<StampedPose>& poses) {
  const Pose first = poses.front().pose;
  const Quat rotation = fromYawPitchRoll(yaw - headingOf(first.rotation), 0, 0);
  const Pose movedFromRecorded{rotation, position - toMatrix(rotation) * first.translation};
  for (StampedPose& p : poses) p.pose = movedFromRecorded * p.pose;
}

// Throws InputError if there are fewer than two poses, a position or time is out of bounds, or times do not ascend.
void checkPoses(const std::vector<StampedPose>& poses, const std::filesystem::path& file) {
  if (poses.size() < 2) {
    throw InputError({file.string()}, "has {} poses, but a moving vehicle needs at least two", poses.size());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    checkedPosition(poses[i].pose.translation, {file.string(), poses[i].line});
    if (std::fabs(poses[i].time) > kLatest) {
      throw InputError({file.string(), poses[i].line},
                       "has the time {:.6g} s: times must be in seconds, or in a .csv table in a column "
                       "time_ms, time_us or time_ns",
                       poses[i].time);
    }
    if (i == 0 || poses[i].time > poses[i - 1].time) continue;
    throw InputError({file.string(), poses[i].line},
                     "pose {} has the time {:.6f} s, which is not after that of the pose before it, {:.6f} s", i + 1,
                     poses[i].time, poses[i - 1].time);
  }
}

}  // namespace

RecordedPoses::RecordedPoses(std::vector<StampedPose> poses) : poses_(std::move(poses)) {
  const double first = poses_.front().time;
  for (StampedPose& p : poses_) p.time -= first;
}

Vec3d RecordedPoses::velocityAt(std::size_t index) const {
  const auto meanVelocity = [&](std::size_t from) {  // m/s, from a pose to the next pose
    const StampedPose& a = poses_[from];
    const StampedPose& b = poses_[from + 1];
    return (b.pose.translation - a.pose.translation) * (1 / (b.time - a.time));
  };
  if (index == 0 || index + 1 == poses_.size()) return meanVelocity(index == 0 ? 0 : index - 1);
  const Vec3d before = meanVelocity(index - 1);
  const Vec3d after = meanVelocity(index);
  const double timeBefore = poses_[index].time - poses_[index - 1].time;
  const double timeAfter = poses_[index + 1].time - poses_[index].time;
  const Vec3d velocity = (before * timeAfter + after * timeBefore) * (1 / (timeBefore + timeAfter));
  const double speed = scanmill::length(velocity);
  const double largestSpeed = 3 * std::min(scanmill::length(before), scanmill::length(after));
  return speed > largestSpeed ? velocity * (largestSpeed / speed) : velocity;
}

Pose RecordedPoses::at(double time) const {
  if (time <= 0) return poses_.front().pose;
  if (time >= duration()) return poses_.back().pose;
  const auto later = std::ranges::upper_bound(poses_, time, {}, &StampedPose::time);
  const auto i = static_cast<std::size_t>(later - poses_.begin()) - 1;
  const StampedPose& a = poses_[i];
  const StampedPose& b = poses_[i + 1];
  const double span = b.time - a.time;
  const double u = (time - a.time) / span;
  // Cubic Hermite interpolation; `start` and `end` are the derivatives with respect to u.
  const Vec3d start = velocityAt(i) * span;
  const Vec3d end = velocityAt(i + 1) * span;
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

std::string RecordedPoses::warning() const {
  constexpr double kFastest = 100;       // m/s
  constexpr double kLeastSpeed = 0.5;    // m/s; below this speed the direction of travel is not tested
  constexpr double kMostTilt = 20;       // degrees, largest mean tilt
  constexpr double kMostDeviation = 45;  // degrees, largest mean angle between the heading and the direction of travel
  double fastest = 0;                    // m/s
  double fastestTime = 0;                // s
  double uprightSum = 0;                 // sum of the cosines of the tilt
  double aheadSum = 0;                   // m moved along the heading
  double movedSum = 0;                   // m moved at kLeastSpeed or faster
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    const Vec3d step = poses_[i].pose.translation - poses_[i - 1].pose.translation;
    const double speed = scanmill::length(step) / (poses_[i].time - poses_[i - 1].time);
    const Mat3 axes = toMatrix(poses_[i].pose.rotation);
    if (speed > fastest) fastestTime = poses_[i].time;
    fastest = std::max(fastest, speed);
    uprightSum += axes.z.z;
    if (speed < kLeastSpeed) continue;
    movedSum += scanmill::length(step);
    aheadSum += dot(axes.x, step);
  }
  const auto angle = [](double cosine) { return degrees(std::acos(std::clamp(cosine, -1.0, 1.0))); };
  const double tilt = angle(uprightSum / static_cast<double>(poses_.size() - 1));
  const double deviation = movedSum > 0 ? angle(aheadSum / movedSum) : 0;
  if (fastest <= kFastest && tilt <= kMostTilt && deviation <= kMostDeviation) return {};
  return fmt::format(
      "the vehicle drives at up to {:.4g} m/s (at {:.6g} s), is tilted by {:.0f} degrees on average and heads {:.0f} "
      "degrees off its way: are times in s, positions in m and angles in degrees (columns yaw_deg, pitch_deg, "
      "roll_deg), is the order of the quaternion right, or are the poses of a camera (`frame: camera`)?",
      fastest, fastestTime, tilt, deviation);
}

RecordedPoses readRecordedPoses(const Value& value) {
  Fields f(value, "recorded");
  f.also({"file", "format", "times", "interval", "calib", "scene", "frame", "start"}).finish();
  const std::filesystem::path file = f.path("file");
  const std::string format = formatOf(f, file);
  const std::string advice = "is not for poses of the format " + format;
  if (format != "kitti") f.refuse({"times", "interval", "calib"}, advice);
  if (format != "nuscenes") f.refuse({"scene"}, advice);
  if (format != "tum" && format != "csv") f.refuse({"frame"}, advice);
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
  checkPoses(poses, file);
  if (const Value* start = f.find("start")) {
    Fields pose(*start, "start");
    pose.also({"position", "yaw_deg"}).finish();
    const Vec3d position = pose.vec3("position", poses.front().pose.translation);
    const double yaw = radians(pose.number("yaw_deg", {-360, 360}, degrees(headingOf(poses.front().pose.rotation))));
    startAt(checkedPosition(position, start->where), yaw, poses);
  }
  return RecordedPoses(std::move(poses));
}

}  // namespace scanmill
