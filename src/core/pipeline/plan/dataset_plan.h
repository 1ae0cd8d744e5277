#pragma once

// The plan that a dataset was made by, from its manifest.

#include <filesystem>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// A dataset does not say where its pipeline lay, which differs from machine to machine. What the pipeline names is
// looked for in the current folder, beside the dataset, in the folders above it and their `pipelines` and `scenes`, and
// among what is shipped, in this order.
std::vector<std::filesystem::path> pipelineFolders(const std::filesystem::path& datasetFolder);

// What the pipeline names is looked for in the folder of `pipeline`, or where that is empty in pipelineFolders().
// Throws InputError where not all of it is found, and where what is found gives other samples or shards.
Plan planOfDataset(const Manifest& manifest, const std::filesystem::path& datasetFolder,
                   const std::filesystem::path& pipeline);

// Returns a plan of `method: auto` with the setting that was chosen before, without measuring.
Plan chosenAgain(const Plan& plan, const MethodRecord& chosen);

}  // namespace scanmill
