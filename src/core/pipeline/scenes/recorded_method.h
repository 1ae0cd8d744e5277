#pragma once

#include <memory>

#include "methods/method.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

// Hits, or samples passes, of the pipeline's recording. The pipeline must outlive it.
std::unique_ptr<Method> makeRecordedMethod(const Pipeline& pipeline);

}  // namespace scanmill
