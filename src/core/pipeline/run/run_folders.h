#pragma once

#include "pipeline/plan/plan.h"
#include "pipeline/run/generate.h"

namespace scanmill {

// Throws InputError unless the dataset and each of its recordings have a folder of their own, none within another:
// otherwise --overwrite for one of them could remove files of another.
void checkFolders(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
