#pragma once

// Finds the scene in which a sample was scanned.

#include <filesystem>
#include <optional>
#include <string>

#include "dataset/manifest.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

// Returns the scene of a sequence at a time (s since the drive began). The manifest does not record the pipeline's
// folder, so the scene's path is tried from each of pipelineFolders(). If the scene is not found or `sequence` is null,
// returns nothing, and `why` receives the reason.
std::optional<SceneChoice> sceneOf(const SequenceRecord* sequence, const std::filesystem::path& datasetFolder,
                                   double time, std::string& why);

// Returns the scene file of a dataset's own vehicle; nothing if there is none, or if it is not found.
std::optional<std::filesystem::path> vehicleOf(const Manifest& manifest, const std::filesystem::path& datasetFolder);

// Throws InputError if the file is not a scene.
void requireScene(const std::filesystem::path& file);

}  // namespace scanmill
