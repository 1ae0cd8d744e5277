#pragma once

// Reads the key `output` of a pipeline: what samples hold, in which formats, and how they are distributed over shards.

#include "config/value.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// Throws InputError.
Output readOutput(const Value& value);

}  // namespace scanmill
