#pragma once

// Measures the cost of each optional feature of a pipeline by leaving it out, so that a pipeline can model only what is
// required.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"

namespace scanmill {

// The cost of one frame with all sensors. Tracing is timed on all threads, everything else on one.
struct FrameCost {
  double traceSeconds = 0;
  double effectsSeconds = 0;
  double encodeSeconds = 0;
  double bytes = 0;

  double seconds() const { return traceSeconds + effectsSeconds + encodeSeconds; }
};

struct FeatureCost {
  std::string feature;  // "effect range_noise", "column time", "alpha cut-outs"
  bool present = true;  // false: the pipeline does not have the feature, and the cost is that of adding it
  FrameCost cost;       // the cost with the feature minus that without it
  double scatter = 0;   // s by which repeats and equal frames differ: a smaller cost says nothing
};

struct FeatureCosts {
  std::string frame;         // the sample's key
  std::uint64_t points = 0;  // points of the frame; 0: the costs are meaningless
  FrameCost whole;           // cost of the unchanged pipeline
  std::vector<FeatureCost> features;
};

struct FeatureEffort {
  int rounds = 14;                                 // most rounds; a round measures each variant once
  double seconds = 1e300;                          // time for all rounds: slow frames have fewer rounds, at least two
  std::function<void(int round, int of)> begun{};  // called before each round; the first warms up
};

// Measures the features on the middle frame of the first sequence. The variants run in turn, and the least time of each
// stage counts. The pipeline needs scenes and a method, not a recording or `auto`.
FeatureCosts measureFeatures(const Pipeline& pipeline, const FeatureEffort& effort);

}  // namespace scanmill
