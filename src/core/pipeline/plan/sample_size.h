#pragma once

// Computes an upper bound of a sample's size before the first ray is traced.

#include <cstdint>

#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns an upper bound of the size of a sample in its shard (bytes). The bound does not hold if an ontology has very
// many or very long class names, or if more than a thousand objects are near the sensors.
double mostSampleBytes(const Plan& plan);

}  // namespace scanmill
