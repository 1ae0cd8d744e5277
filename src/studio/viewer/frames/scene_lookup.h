#pragma once

// Which scene a sample was made of.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "viewer/frames/frame_source.h"

namespace scanmill {

// The entry under `scenes:` of the pipeline whose scene and seed make the sample's key. A relative file is looked for
// where the program runs, in the dataset's folder and among the program's own files: the manifest does not say where
// the pipeline was. None where that fails, and then `why` says what is missing.
std::optional<SceneChoice> sceneOfSample(const std::string& pipelineText, const std::filesystem::path& datasetFolder,
                                         const std::string& key, std::string& why);

// What follows "-s" in "street-s3-lane-000012"; 1 where a key holds no seed.
std::uint64_t seedOfKey(const std::string& key);

// Throws InputError unless the file is a scene.
void requireScene(const std::filesystem::path& file);

}  // namespace scanmill
