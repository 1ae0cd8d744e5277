#pragma once

// Finds the scene that a sample was made of.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "viewer/frames/frame_source.h"

namespace scanmill {

// Finds the entry under `scenes:` of the pipeline whose scene and seed make the sample's key. Since the manifest does
// not say where the pipeline was, a relative file is looked for where the program runs, in the dataset's folder and
// among the program's own files. Absent where it is not found; then `why` says what is missing. `time` is the sample's
// (s since the drive began).
std::optional<SceneChoice> sceneOfSample(const std::string& pipelineText, const std::filesystem::path& datasetFolder,
                                         const std::string& key, double time, std::string& why);

// The seed of the scene by the sample's key: 3 for "street-s3-lane-000012"; 1 where a key holds no seed.
std::uint64_t seedOfKey(const std::string& key);

// Throws InputError unless the file is a scene.
void requireScene(const std::filesystem::path& file);

}  // namespace scanmill
