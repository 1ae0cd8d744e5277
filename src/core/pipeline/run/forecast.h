#pragma once

// Forecasts how long a dataset takes to make and how large it becomes, without loading its scenes: a few samples of a
// small town are made on this machine, with the pipeline's sensors, method, effects and formats, and their costs are
// scaled to the pipeline's scenes. tests/benchmarks/forecast.cpp compares the result with complete datasets.

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
  std::uint64_t frames = 0;
  int threads = 0;
  Estimate seconds;  // wall time from the start of the program to the manifest
  Estimate bytes;    // size of all shards together
};

// The costs of a pipeline's scenes and frames on this machine.
struct SampleCosts {
  int threads = 0;                 // threads that work at a time
  int cores = 0;                   // cores for these threads
  double sceneSeconds = 0;         // processor seconds to set up a scene, on the mean over the pipeline's scenes
  double slowestSceneSeconds = 0;  // s of wall time to set one up with all threads
  double frameSeconds = 0;         // thread seconds of a frame while all threads work
  double frameBytes = 0;           // size of a sample in its shard
  double timeSpread = 1;           // factor by which a dataset may take longer or shorter than expected
  double byteSpread = 1;           // factor by which it may be larger or smaller than expected
};

// Reads the plan's pipeline again, with these arguments of --set after all others.
using Reread = std::function<Pipeline(const std::vector<std::string>&)>;

// Measures these costs by making one sample of the small town for each thread. If the pipeline has recorded hits or
// passes, makes its own first samples instead. Throws InputError if the small town cannot stand for the pipeline's
// scenes, for instance if an effect needs a class that towns do not have.
SampleCosts measureSampleCosts(const Plan& plan, const Reread& reread);

// True if a scene file of the pipeline holds a town, a street or values that are random for each seed. In other scenes,
// further seeds mostly give the same place again.
bool followsFromSeeds(const Pipeline& pipeline);

// Returns the number of scenes that a pipeline sets up: each scene file with each of its seeds.
std::uint64_t scenesOf(const Pipeline& pipeline);

// Returns the forecast for `frames` frames in `scenes` scenes.
Forecast forecast(const SampleCosts& costs, std::uint64_t frames, std::uint64_t scenes);

}  // namespace scanmill
