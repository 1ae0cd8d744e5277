#pragma once

#include <memory>

#include "methods/interface/method.h"

namespace scanmill {

// YAML: particle: {voxel_m: 0.1, voxels: 256, levels: auto, refine: triangle, steps: 512, backend: cpu}
std::unique_ptr<Method> makeParticle(const Scene& scene, Fields& options);

}  // namespace scanmill
