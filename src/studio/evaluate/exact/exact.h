#pragma once

// Traces the hits of beams in double precision throughout: the truth against which methods are measured. It is slow,
// and pipelines cannot name it as a method.

#include <memory>
#include <vector>

#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

struct ExactHits {
  Hits hits;                  // the ranges are rounded to float
  std::vector<double> range;  // m, per beam; infinite for a miss
};

class ExactTracer {
 public:
  // The scene must outlive the tracer.
  explicit ExactTracer(const Scene& scene);
  ~ExactTracer();
  ExactTracer(const ExactTracer&) = delete;
  ExactTracer& operator=(const ExactTracer&) = delete;

  // Traces a shot by the rules of Method::trace(): range limits, channels, alpha cut-outs, and the lowest instance id
  // among coplanar surfaces. Several threads may call it at once.
  void trace(const Shot& shot, Channels channels, ExactHits& hits) const;

 private:
  class Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace scanmill
