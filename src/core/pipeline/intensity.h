#pragma once

// Intensities as a pipeline's own effect has them, without any noise: what methods are compared by.

#include <functional>
#include <vector>

#include "pipeline/pipeline.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// Per beam; null where no effect of the pipeline sets the intensity. Pipeline and scene must outlive it. Hits need the
// channels that the effects read.
std::function<std::vector<float>(const Shot&, const Hits&)> noiseFreeIntensity(const Pipeline& pipeline,
                                                                               const Scene& scene);

}  // namespace scanmill
