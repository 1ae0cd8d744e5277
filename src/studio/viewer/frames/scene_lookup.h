#pragma once

// Finds the scene that a sample was scanned in.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "viewer/frames/frame_source.h"

namespace scanmill {

// Finds the entry under `scenes:` of the pipeline whose scene and seed form the beginning of the sample's key. Since
// the manifest does not record the pipeline's folder, a relative path is looked up in the current folder, in the
// dataset's folder and among the program's own files. Absent if the scene is not found; then `why` says what is
// missing. `time`: of the sample (s since the drive began).
std::optional<SceneChoice> sceneOfSample(const std::string& pipelineText, const std::filesystem::path& datasetFolder,
                                         const std::string& key, double time, std::string& why);

// Returns the seed of the scene in the sample's key: 3 for "street-s3-lane-000012"; 1 if the key contains no seed.
std::uint64_t seedOfKey(const std::string& key);

// Throws InputError unless the file is a scene.
void requireScene(const std::filesystem::path& file);

}  // namespace scanmill
