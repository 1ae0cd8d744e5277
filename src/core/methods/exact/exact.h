#pragma once

// What beams meet, in double precision throughout: the truth that methods are measured against. Slow and of no row in
// methods().

#include <memory>
#include <vector>

#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

struct ExactHits {
  Hits hits;                  // the range rounded to float
  std::vector<double> range;  // m; infinite for a miss
};

class ExactTracer {
 public:
  // The scene must outlive it.
  explicit ExactTracer(const Scene& scene);
  ~ExactTracer();
  ExactTracer(const ExactTracer&) = delete;
  ExactTracer& operator=(const ExactTracer&) = delete;

  // As Method::trace(): range limits, channels, alpha cut-outs, and of coplanar surfaces the lowest instance id. Safe
  // to call from several threads at once.
  void trace(const Shot& shot, Channels channels, ExactHits& hits) const;

 private:
  class Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace scanmill
