#pragma once

// Finds the models of Gazebo and the packages of ROS that files name by model:// and package://.

#include <filesystem>
#include <optional>
#include <string>

namespace scanmill {

// Returns the file or folder `name` in the first folder that has it; nullopt if none has. Searched are the folder of
// `file`, up to 7 folders above it, the folder "models" in each of these, and the folders in the environment variables
// SDF_PATH, GZ_SIM_RESOURCE_PATH, IGN_GAZEBO_RESOURCE_PATH, GAZEBO_MODEL_PATH and ROS_PACKAGE_PATH.
std::optional<std::filesystem::path> findInModelFolders(const std::filesystem::path& file, const std::string& name);

// Returns the names of these variables, for messages.
std::string modelFolderVariables();

}  // namespace scanmill
