#pragma once

// Forecasts how long a dataset takes to make and how large it becomes, without loading its scenes. For this, a few
// samples of a small town are made on this machine, with the pipeline's sensors, method, effects and formats, and their
// costs are scaled to the pipeline's scenes. `generate` prints its forecast beside the actual figures.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/plan/plan.h"

namespace scanmill {

struct Estimate {
  double least = 0;
  double expected = 0;
  double most = 0;
};

struct Forecast {
  int threads = 0;
  Estimate seconds;  // wall time from the start of the program to the manifest (s)
  Estimate bytes;    // size of all shards (bytes)
};

// The costs of a pipeline's scenes and frames on this machine.
struct SampleCosts {
  int threads = 0;                 // number of threads that work at a time
  int cores = 0;                   // number of processor cores that the threads run on
  double sceneSeconds = 0;         // processor time to set up a scene (s), averaged over the pipeline's scenes
  double slowestSceneSeconds = 0;  // wall time to set up the slowest scene with all threads (s)
  double frameSeconds = 0;         // time that one thread takes for a frame while all threads work (s)
  double frameBytes = 0;           // size of a frame's sample in its shard (bytes)
  double timeSpread = 1;           // factor by which the time may be longer or shorter than expected
  double byteSpread = 1;           // factor by which the size may be larger or smaller than expected
};

// Reads the plan's pipeline again with additional arguments of --set, which override all earlier arguments.
using Reread = std::function<Pipeline(const std::vector<std::string>&)>;

// Measures the costs of samples by making one sample of the small town for each thread. If the pipeline has a
// recording, makes the recording's first samples instead. Throws InputError if the small town cannot replace the
// pipeline's scenes, for instance because an effect needs a class that towns do not have.
SampleCosts measureSampleCosts(const Plan& plan, const Reread& reread);

// True if a scene file of the pipeline contains a town, a street or values that are random for each seed. Other scenes
// are mostly the same for all seeds.
bool followsFromSeeds(const Pipeline& pipeline);

// Returns the number of scenes that a pipeline sets up: consecutive sequences with the same scene set it up once.
std::uint64_t scenesOf(const Pipeline& pipeline);

// Returns the forecast for `frames` frames in `scenes` scenes.
Forecast forecast(const SampleCosts& costs, std::uint64_t frames, std::uint64_t scenes);

}  // namespace scanmill
