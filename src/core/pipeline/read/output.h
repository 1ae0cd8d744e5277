#pragma once

// Reads the key `output` of a pipeline: the contents and formats of samples, and their distribution over shards.

#include "config/value.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// Reads and checks the options of the key `output`. Throws InputError.
Output readOutput(const Value& value);

}  // namespace scanmill
