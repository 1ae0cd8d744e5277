#pragma once

// Files of recorded poses. All throw InputError with the file and, where it has lines, the line.

#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "sensors/recorded_poses.h"

namespace scanmill {

// The rotation, of length 1 exactly; throws where its length is farther than a hundredth from 1.
Quat checkedRotation(const Quat& q, const Location& where);

std::vector<Affine> readKittiPoses(const std::filesystem::path& file);
std::vector<double> readTimes(const std::filesystem::path& file);  // s, one a line
// cameraFromScanner, the row `Tr` of a calib.txt of KITTI's odometry.
Affine readKittiCalibration(const std::filesystem::path& file);
std::vector<StampedPose> readTumPoses(const std::filesystem::path& file);
std::vector<StampedPose> readPoseTable(const std::filesystem::path& file);
// The poses at which the scans of a scene were taken; `file` is the table ego_pose.json, beside which scene.json,
// sample.json and sample_data.json lie.
std::vector<StampedPose> readNuScenesPoses(const std::filesystem::path& file, const std::string& scene);

}  // namespace scanmill
