#pragma once

// How large a sample can become, known before the first ray.

#include <cstdint>

#include "pipeline/plan/plan.h"

namespace scanmill {

// Upper bound of the bytes of a sample in its shard, but for classes of very many or very long names, and for more than
// a thousand objects where samples list them.
double mostSampleBytes(const Plan& plan);

}  // namespace scanmill
