#pragma once

// Traces the hits of beams completely in double precision. Methods are measured against these exact hits. The exact
// tracer is slow, and cannot be used as the method of a pipeline.

#include <memory>
#include <vector>

#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

struct ExactHits {
  Hits hits;                  // the hits; their ranges are rounded to float
  std::vector<double> range;  // range of each beam (m); infinity for a miss
};

class ExactTracer {
 public:
  // `scene` must outlive this object.
  explicit ExactTracer(const Scene& scene);
  ~ExactTracer();
  ExactTracer& operator=(ExactTracer&&) = delete;  // neither copied nor moved

  // Traces a shot with the same rules as Method::trace() for range limits, channels, alpha cut-outs, and the lowest
  // instance id among coplanar surfaces. May be called from several threads at a time.
  void trace(const Shot& shot, Channels channels, ExactHits& hits) const;

 private:
  class Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace scanmill
