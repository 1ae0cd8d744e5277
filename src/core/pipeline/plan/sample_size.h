#pragma once

// Bounds the size of a sample before the first ray is traced.

#include <cstdint>

#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns an upper bound of the bytes of a sample in its shard. Ontologies with very many or very long class names may
// exceed it, and so may lists of more than a thousand objects.
double mostSampleBytes(const Plan& plan);

}  // namespace scanmill
