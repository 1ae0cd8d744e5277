#pragma once

#include "pipeline/plan/plan.h"
#include "pipeline/run/generate.h"

namespace scanmill {

// The dataset and its recordings each need a folder of their own, none within another: --overwrite must know what is
// whose. Throws InputError.
void checkFolders(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
