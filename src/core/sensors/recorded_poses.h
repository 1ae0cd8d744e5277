#pragma once

// Where a vehicle was, as it was recorded: poses of KITTI's odometry, of TUM's trajectories, of nuScenes and of tables.

#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// A pose at a time (s).
struct StampedPose {
  double time = 0;
  Pose pose;
  int line = 0;  // of its file; 0 where that has none
};

// In between positions follow a cubic curve (Hermite's), whose velocity at a pose is that of the parabola through it
// and its neighbours, at most three times the slower of the mean velocities before and behind it (Fritsch and Carlson,
// "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal. 1980), so that nothing overshoots. Rotations turn
// evenly.
class RecordedPoses {
 public:
  // At least two, the times ascending.
  explicit RecordedPoses(std::vector<StampedPose> poses);

  // Where the vehicle is, so many s after the first pose; before the first and after the last it stands.
  Pose at(double time) const;
  double duration() const { return poses_.back().time; }  // s
  double length() const;                                  // m, straight from pose to pose
  std::vector<double> times() const;                      // s since the first pose, of each
  // "412 poses in 41.2 s, 310 m, at most 0.31 s apart, 7.52 m/s"
  std::string about() const;
  // What is legal but seldom meant, in words: too fast, upside down, or heading elsewhere than it drives; else empty.
  std::string doubt() const;

 private:
  std::vector<StampedPose> poses_;  // the first at the time 0
};

// From YAML:
//
//   recorded:
//     file: poses/00.txt
//     format: kitti                  # kitti, tum, nuscenes, csv; default: by the file's name
//     times: sequences/00/times.txt  # kitti: s, one a line; or
//     interval: 0.1                  # s from pose to pose
//     calib: sequences/00/calib.txt  # kitti: then the poses are those of the laser scanner (Tr), else of the camera,
//                                    # turned so that x is forward and z up
//     scene: scene-0061              # nuscenes: the file is v1.0-*/ego_pose.json; the other tables lie beside it
//     frame: vehicle                 # tum, csv: what the poses are of: vehicle (x forward, z up), or camera (z
//                                    # forward, y down)
//     start: {position: [x, y, z], yaw_deg: 90}   # where the first pose is to be, and whither it is to head; what is
//                                    # not said stays as it was recorded
//
// KITTI: Geiger, Lenz, Urtasun, "Are we ready for autonomous driving?", CVPR 2012: 12 numbers a line, the first three
// rows of the matrix that takes points of the left camera to its first frame. TUM: Sturm et al., "A benchmark for the
// evaluation of RGB-D SLAM systems", IROS 2012: `time x y z qx qy qz qw`. Tables have a first line with the names of
// their columns: time (s; or time_ms, time_us, time_ns), x, y, z (m), and qw, qx, qy, qz, or yaw, pitch, roll (rad; or
// yaw_deg, ...), or neither, where the vehicle heads along its way. Throws InputError with the file and its line.
RecordedPoses readRecordedPoses(const Value& value);

}  // namespace scanmill
