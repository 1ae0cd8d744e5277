#pragma once

// Recreates the plan of an existing dataset from its manifest.

#include <filesystem>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns the folders in which the pipeline file of a dataset may have been. The manifest does not store this folder,
// since it differs from machine to machine. The result is, in search order: the current folder, the dataset's folder,
// each folder above it and the `pipelines` and `scenes` folders in these, and the folders that are installed with the
// program.
std::vector<std::filesystem::path> pipelineFolders(const std::filesystem::path& datasetFolder);

// Returns the plan of a dataset. The files that the dataset's pipeline names are searched for in the folder of the
// pipeline file `pipeline` or, if `pipeline` is empty, in pipelineFolders(). Throws InputError if a file is not found,
// or if the plan made from these files has other samples or shards than the dataset.
[[nodiscard]] Plan planOfDataset(const Manifest& manifest, const std::filesystem::path& datasetFolder,
                                 const std::filesystem::path& pipeline);

}  // namespace scanmill
