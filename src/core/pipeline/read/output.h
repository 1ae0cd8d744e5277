#pragma once

// Reads the key `output` of a pipeline: what samples hold, in which formats, and how they are shared out over shards.

#include "config/value.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// Fills the layout, formats, voxels, objects and what the pipeline says of shards. Throws InputError.
void readOutput(const Value& value, Pipeline& pipeline);

}  // namespace scanmill
