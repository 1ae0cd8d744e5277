#pragma once

#include "pipeline/plan/plan.h"
#include "pipeline/run/generate.h"

namespace scanmill {

// Throws InputError if two of the folders for the dataset and its recordings are the same, or one is within another:
// --overwrite for one of them could then remove files of the other.
void checkFolders(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
