#pragma once

// How large a dataset can become, known before the first ray.

#include "pipeline/plan/plan.h"

namespace scanmill {

// Upper bound of the bytes of shards and manifest, whatever the beams meet. `ontology`: of the scenes.
double mostDatasetBytes(const Plan& plan, const Ontology& ontology);

// Upper bound of the bytes of a sample in its shard, but for classes of very many or very long names.
double mostSampleBytes(const Plan& plan);

}  // namespace scanmill
