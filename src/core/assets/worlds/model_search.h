#pragma once

// Finds the models and meshes that descriptions of worlds name.

#include <filesystem>
#include <optional>
#include <string>

#include "assets/worlds/xml.h"

namespace scanmill {

// The file or folder that `from` calls `uri`, in a file: model://NAME/..., package://NAME/..., file://... or a path
// relative to the file. The folders of models are looked for beside the file's own folder and those above it, also in
// their folders "models", and in the environment variables SDF_PATH, GZ_SIM_RESOURCE_PATH, IGN_GAZEBO_RESOURCE_PATH,
// GAZEBO_MODEL_PATH and ROS_PACKAGE_PATH. Throws InputError at `from` where there is none.
std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri);

// What is called `name` in the folders in which the models of a file are looked for; nothing where it is in none.
std::optional<std::filesystem::path> findInModelFolders(const std::filesystem::path& file, const std::string& name);

}  // namespace scanmill
