#pragma once

// Makes the plan of an existing dataset anew, from its manifest.

#include <filesystem>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns the folders in which the pipeline of a dataset may have been. A dataset does not say where that was, since it
// differs from machine to machine. The folders are, in the order in which files are looked for: the current folder, the
// dataset's, the folders above it with their `pipelines` and `scenes`, and those that come with the program.
std::vector<std::filesystem::path> pipelineFolders(const std::filesystem::path& datasetFolder);

// Returns the plan of a dataset. The files that its pipeline names are looked for in the folder of `pipeline`, or in
// pipelineFolders() if `pipeline` is empty. Throws InputError if a file is not found, or if the plan made from the
// files has other samples or shards than the dataset.
[[nodiscard]] Plan planOfDataset(const Manifest& manifest, const std::filesystem::path& datasetFolder,
                                 const std::filesystem::path& pipeline);

// Returns a plan of `method: auto` with the method and options that were chosen before, without measuring again.
[[nodiscard]] Plan chosenAgain(const Plan& plan, const MethodRecord& chosen);

}  // namespace scanmill
