#pragma once

#include <memory>

#include "methods/method.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// Returns a method that does not trace: it returns the recorded hits of the pipeline's recording, or samples its
// recorded passes. The pipeline must outlive the method.
std::unique_ptr<Method> makeRecordedMethod(const Pipeline& pipeline);

}  // namespace scanmill
