#pragma once

// What each optional feature of a pipeline costs, measured by leaving it out: model only what a scene requires.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"

namespace scanmill {

// Of one frame, all sensors; seconds on one thread but for tracing, which takes all.
struct FrameCost {
  double traceSeconds = 0;
  double effectsSeconds = 0;
  double encodeSeconds = 0;
  double bytes = 0;

  double seconds() const { return traceSeconds + effectsSeconds + encodeSeconds; }
};

struct FeatureCost {
  std::string feature;  // "effect range_noise", "column time", "alpha cut-outs"
  bool present = true;  // false: the pipeline does without it, and the cost is that of adding it
  FrameCost cost;       // with it less without it
  double scatter = 0;   // s, of repeats, and of what equal frames differ by: a cost below it says nothing
};

struct FeatureCosts {
  std::string frame;         // the sample's key
  std::uint64_t points = 0;  // of the frame; without any the costs say nothing
  FrameCost whole;           // as the pipeline stands
  std::vector<FeatureCost> features;
};

struct FeatureEffort {
  int rounds = 14;                                 // in which each variant is measured once, at most
  double seconds = 1e300;                          // that they should take: slow frames have fewer rounds, at least two
  std::function<void(int round, int of)> begun{};  // called before each round; the first warms up
};

// Runs the middle frame of the first sequence, each variant in turn, and takes the least time of each stage. The
// pipeline needs scenes and a method, not a recording or `auto`.
FeatureCosts measureFeatures(const Pipeline& pipeline, const FeatureEffort& effort);

}  // namespace scanmill
