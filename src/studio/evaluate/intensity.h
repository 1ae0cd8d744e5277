#pragma once

// Computes intensities with a pipeline's effects but without noise, to compare methods.

#include <functional>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns a function that computes the noise-free intensity of each beam of a shot from its hits, which must have the
// channels that the effects read. The function is null if no effect of the pipeline sets the intensity. `pipeline` and
// `scene` must outlive the function.
std::function<std::vector<float>(const Shot&, const Hits&)> noiseFreeIntensity(const Pipeline& pipeline,
                                                                               const Scene& scene);

}  // namespace scanmill
