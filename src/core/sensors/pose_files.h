#pragma once

// Reads files of recorded poses. All readers throw InputError with the file and, if it has lines, the line.

#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "sensors/recorded_poses.h"

namespace scanmill {

struct FormatSupport;
const FormatSupport& poseFormat();

// Returns the rotation scaled to length 1. Throws InputError if the length of `q` differs from 1 by a hundredth or
// more.
Quat checkedRotation(const Quat& q, const Location& where);

std::vector<Affine> readKittiPoses(const std::filesystem::path& file);
std::vector<double> readTimes(const std::filesystem::path& file);  // returns the times (s), one per line of the file
// Returns cameraFromScanner, the row `Tr` of a calib.txt of KITTI's odometry.
Affine readKittiCalibration(const std::filesystem::path& file);
std::vector<StampedPose> readTumPoses(const std::filesystem::path& file);
std::vector<StampedPose> readPoseTable(const std::filesystem::path& file);
// Returns the poses of the vehicle at the times of a scene's scans. `file`: the table ego_pose.json, whose folder must
// also contain scene.json, sample.json and sample_data.json.
std::vector<StampedPose> readNuScenesPoses(const std::filesystem::path& file, const std::string& scene);

}  // namespace scanmill
