#pragma once

// Finds the models and meshes that world descriptions name.

#include <filesystem>
#include <optional>
#include <string>

#include "assets/worlds/xml.h"

namespace scanmill {

// Returns the file or folder that the element `from` of `file` calls `uri`: model://NAME/..., package://NAME/...,
// file://... or a path relative to the file. Models are searched for in the file's folder, up to 7 folders above it,
// the folder "models" in each of these, and the folders in the environment variables SDF_PATH, GZ_SIM_RESOURCE_PATH,
// IGN_GAZEBO_RESOURCE_PATH, GAZEBO_MODEL_PATH and ROS_PACKAGE_PATH. If nothing is found, throws InputError at `from`.
std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri);

// Returns the file or folder `name` in the first of the folders that findModel() searches for models of `file`; nullopt
// if none of the folders has it.
std::optional<std::filesystem::path> findInModelFolders(const std::filesystem::path& file, const std::string& name);

}  // namespace scanmill
