#pragma once

// Recorded poses of a vehicle and the readers of their files: KITTI's odometry, TUM's trajectories, nuScenes, tables.
// All readers throw InputError with the file and, if it has lines, the line.

#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// A pose with its time (s).
struct StampedPose {
  double time = 0;
  Pose pose;
  int line = 0;  // line of the file; 0: the file has no lines
};

// Interpolates recorded poses. Positions follow a cubic Hermite curve. The curve's velocity at a pose is the velocity
// of the parabola through the pose and its two neighbours, but at most three times the slower of the mean velocities
// before and after the pose (Fritsch and Carlson, "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal. 1980),
// so that the curve does not overshoot. Rotations are interpolated at constant angular velocity from pose to pose.
class RecordedPoses {
 public:
  // `poses`: at least two, with ascending times.
  explicit RecordedPoses(std::vector<StampedPose> poses);

  // Returns the pose at a time (s after the first pose). The vehicle stands still before the first and after the last
  // pose.
  Pose at(double time) const;
  double duration() const { return poses_.back().time; }  // s, time of the last pose
  double length() const;                                  // m, sum of the straight distances from pose to pose
  std::vector<double> times() const;                      // s since the first pose, one per pose
  // Returns a description for messages: "412 poses in 41.2 s, 310 m, at most 0.31 s apart, 7.52 m/s".
  std::string about() const;
  // Returns a warning about poses that are possible but probably wrong: too fast, tilted, or with a heading far from
  // the direction of travel. Empty if the poses are plausible.
  std::string warning() const;

 private:
  // Returns the velocity of the curve (m/s) at a pose.
  Vec3d velocityAt(std::size_t index) const;

  std::vector<StampedPose> poses_;  // ascending in time; the time of the first pose is 0
};

// Reads the map `recorded` of a trajectory. docs/keys.md explains its keys. KITTI (Geiger, Lenz, Urtasun, "Are we ready
// for autonomous driving?", CVPR 2012) has 12 numbers per line, the first three rows of the matrix that transforms
// points from the left camera's frame to its first frame. TUM (Sturm et al., "A benchmark for the evaluation of RGB-D
// SLAM systems", IROS 2012) has `time x y z qx qy qz qw`. Throws InputError with the file and the line number.
RecordedPoses readRecordedPoses(const Value& value);

struct FormatSupport;
extern const FormatSupport kPoseFormat;

std::vector<Affine> readKittiPoses(const std::filesystem::path& file);
std::vector<double> readTimes(const std::filesystem::path& file);  // returns the times (s), one per line of the file
// Returns cameraFromScanner from the line `Tr` or `Tr_velo_to_cam` of KITTI's calib.txt; throws InputError without it.
Affine readKittiCalibration(const std::filesystem::path& file);
std::vector<StampedPose> readTumPoses(const std::filesystem::path& file);
std::vector<StampedPose> readPoseTable(const std::filesystem::path& file);
// Returns the poses of the vehicle at the lidar scans of the scene named `scene`. `file`: the table ego_pose.json,
// whose folder must also contain scene.json, sample.json and sample_data.json.
std::vector<StampedPose> readNuScenesPoses(const std::filesystem::path& file, const std::string& scene);

}  // namespace scanmill
