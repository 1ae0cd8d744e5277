#pragma once

// Measures what each optional feature of a pipeline costs, by running the pipeline with and without it. Users can then
// leave out features that they do not need.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"

namespace scanmill {

// The cost of one frame with all sensors, in processor time.
struct FrameCost {
  double traceSeconds = 0;
  double effectsSeconds = 0;
  double encodeSeconds = 0;
  double bytes = 0;

  double seconds() const { return traceSeconds + effectsSeconds + encodeSeconds; }
};

struct FeatureCost {
  std::string feature;  // name of the feature, such as "effect range_noise", "column time" or "alpha cut-outs"
  bool present = true;  // true: the pipeline has the feature; false: the cost is that of adding the feature
  FrameCost cost;       // cost with the feature minus cost without it
  double scatter = 0;   // timing noise (s); a cost smaller than this is not significant
};

struct FeatureCosts {
  std::string frame;         // key of the measured sample
  std::uint64_t points = 0;  // number of points in the frame; 0: the costs are not meaningful
  FrameCost whole;           // cost of the unchanged pipeline
  std::vector<FeatureCost> features;
};

struct FeatureEffort {
  int rounds = 14;         // maximum number of rounds; a round measures each variant once
  double seconds = 1e300;  // maximum time of all rounds (s); if a frame is slow, fewer rounds are run, but at least two
  std::function<void(int round, int of)> begun{};  // called before each round with its number; round 0 is a warm-up
};

// Measures the features on the middle frame of the first sequence. The variants run in turn, and for each stage the
// least time is used. The pipeline must have scenes and a method other than `auto`; recordings are not supported.
FeatureCosts measureFeatures(const Pipeline& pipeline, const FeatureEffort& effort);

}  // namespace scanmill
