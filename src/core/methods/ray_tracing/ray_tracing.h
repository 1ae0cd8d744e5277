#pragma once

#include <memory>

#include "methods/interface/method.h"

namespace scanmill {

std::unique_ptr<Method> makeRayTracing(const Scene& scene, Fields& options);

}  // namespace scanmill
