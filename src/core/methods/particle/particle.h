#pragma once

#include <memory>

#include "methods/interface/method.h"

namespace scanmill {

// Creates the method from its map in the pipeline: see readParticleOptions(). The scene must outlive the method.
std::unique_ptr<Method> makeParticle(const Scene& scene, Fields& options);

}  // namespace scanmill
