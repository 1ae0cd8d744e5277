#pragma once

// Finds the scene in which a sample was scanned.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "viewer/frames/frame_source.h"

namespace scanmill {

// Finds the entry of the pipeline's key `scenes` whose name and seed are at the start of the sample's key. The manifest
// does not record the pipeline's folder, so a relative path is searched for in the current folder, in the dataset's
// folder and among the files installed with the program. If the scene is not found, returns nothing, and `why` receives
// the reason. `time`: time of the sample (s since the drive began).
std::optional<SceneChoice> sceneOfSample(const std::string& pipelineText, const std::filesystem::path& datasetFolder,
                                         const std::string& key, double time, std::string& why);

// Returns the scene file that the pipeline's key `vehicle` names; nothing if there is none, or if it is not found.
std::optional<std::filesystem::path> vehicleOf(const std::string& pipelineText,
                                               const std::filesystem::path& datasetFolder);

// Returns the seed of the scene in a sample's key, such as 3 in "street-s3-lane-000012"; 1 if the key contains no seed.
std::uint64_t seedOfKey(const std::string& key);

// Throws InputError if the file is not a scene.
void requireScene(const std::filesystem::path& file);

}  // namespace scanmill
