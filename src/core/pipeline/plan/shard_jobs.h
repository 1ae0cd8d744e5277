#pragma once

// Distributes samples over shards. The result follows from the plan alone, so that any thread, process or machine may
// make any shard, in any order.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/parts.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

struct SampleAddress {
  std::size_t sequence = 0;  // index in Pipeline::sequences
  std::uint32_t frame = 0;
  std::uint64_t number = 0;  // among all samples of the plan, in the order of sequences and frames
};

struct ShardJob {
  std::string file;  // relative to the dataset's folder, see shardName()
  std::string split;
  std::vector<SampleAddress> samples;  // in the order of sequences and frames
};

// Returns all shards, split by split. A shard holds `output.shard_samples` samples, the last shard of a split the rest.
// Without that key, the samples of a split are distributed evenly over as many shards as it takes for none to exceed
// `output.shard_mb`, whatever the beams hit; a split of two or more samples has at least two shards, since loaders give
// each worker a shard. With `output.shuffle`, the samples of a shard are drawn from the split at random, from the
// pipeline's seed.
std::vector<ShardJob> shardJobs(const Plan& plan);

// Returns the description of a plan that the parts of a dataset store. Plans of different datasets have different
// hashes. The hash covers the program's version, the pipeline and the chosen method, the sensors and their beams, the
// scene files, vehicle and ontology that the pipeline names, and the names and sizes of a recording's files. Files that
// scenes name (assets, ontologies, materials) are not covered: after a change of these, start a new dataset.
DatasetPlan datasetPlan(const Plan& plan, const std::vector<ShardJob>& jobs);

}  // namespace scanmill
