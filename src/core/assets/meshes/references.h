#pragma once

// Checks the names of other files that an asset's file contains, and finds these files. The asset may be untrusted.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// True if a name leads out of the folder of the asset that contains the name: the name is absolute, or climbs by "..".
// Symbolic links inside of the folder are not checked: the folder's owner is responsible for them.
bool leadsOutside(const std::string& name);

// Returns the message about a name that leads outside. The message quotes the name, and advises allow_outside.
std::string refusalOf(const std::string& name);

// Decodes the escapes of a URI: "%2F" becomes "/". All other text is unchanged.
std::string decodeUri(std::string_view uri);

// Finds the models of Gazebo and the packages of ROS that files name by model:// and package://. Returns the file or
// folder `name` in the first searched folder that has it; nullopt if none has it. The search covers the folder of
// `file`, up to 7 folders above it, the folder "models" in each of these, and the folders in the environment variables
// SDF_PATH, GZ_SIM_RESOURCE_PATH, IGN_GAZEBO_RESOURCE_PATH, GAZEBO_MODEL_PATH and ROS_PACKAGE_PATH.
std::optional<std::filesystem::path> findInModelFolders(const std::filesystem::path& file, const std::string& name);

// Returns the names of the environment variables in which findInModelFolders() searches, for messages.
std::string modelFolderVariables();

// Finds the file that the asset at `asset` calls `name`; empty if there is none. A prefix model:// or file:// is
// resolved first; any name is then tried relative to the asset's folder. Next, its last component is searched for in
// the asset's folder, in the folders near it that usually contain textures, and in `folders`, first case-sensitively,
// then ignoring case. If only a file outside of the asset's folder matches, throws InputError, unless `allowOutside` is
// set.
std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name, bool allowOutside,
                                  const std::vector<std::filesystem::path>& folders = {});

}  // namespace scanmill
