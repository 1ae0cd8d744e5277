#pragma once

// Intensities as a pipeline's own effects make them, but without noise: by these, methods are compared.

#include <functional>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// Gives a function that computes the noise-free intensity of each beam of a shot from its hits, which must have the
// channels that the effects read. The function is null where no effect of the pipeline sets the intensity. Pipeline and
// scene must outlive it.
std::function<std::vector<float>(const Shot&, const Hits&)> noiseFreeIntensity(const Pipeline& pipeline,
                                                                               const Scene& scene);

}  // namespace scanmill
