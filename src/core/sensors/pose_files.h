#pragma once

// Reads files of recorded poses. All readers throw InputError with the file and, if it has lines, the line.

#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "sensors/recorded_poses.h"

namespace scanmill {

// Returns the rotation scaled to length 1; throws if its length differs from 1 by a hundredth or more.
Quat checkedRotation(const Quat& q, const Location& where);

std::vector<Affine> readKittiPoses(const std::filesystem::path& file);
std::vector<double> readTimes(const std::filesystem::path& file);  // s, one per line
// Returns cameraFromScanner, the row `Tr` of a calib.txt of KITTI's odometry.
Affine readKittiCalibration(const std::filesystem::path& file);
std::vector<StampedPose> readTumPoses(const std::filesystem::path& file);
std::vector<StampedPose> readPoseTable(const std::filesystem::path& file);
// Returns the poses at which a scene's scans were taken; `file` is the table ego_pose.json, beside which scene.json,
// sample.json and sample_data.json lie.
std::vector<StampedPose> readNuScenesPoses(const std::filesystem::path& file, const std::string& scene);

}  // namespace scanmill
