#pragma once

// Distributes samples over shards. The distribution depends on the plan alone, so that any thread, process or machine
// can make any shard, in any order.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/parts.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

struct SampleAddress {
  std::size_t sequence = 0;  // index in Pipeline::sequences
  std::uint32_t frame = 0;
  std::uint64_t number = 0;  // index among all samples of the plan, in the order of sequences and frames
};

struct ShardJob {
  std::string file;  // path relative to the dataset's folder, see shardName()
  std::string split;
  std::vector<SampleAddress> samples;  // sorted by sequence, then by frame
};

// Returns an upper bound of the size of a sample in its shard (bytes), before the first ray is traced. The bound does
// not hold if an ontology has very many or very long class names, or if more than a thousand objects are near the
// sensors.
double mostSampleBytes(const Plan& plan);

// Returns all shards, split by split. If the pipeline has the key `output.shard_samples`, each shard has this number of
// samples, except that the last shard of a split may have fewer. Otherwise the samples of a split are distributed
// evenly over as few shards as possible such that no shard of several samples can exceed `output.shard_mb`, whatever
// the beams hit; a split of two or more samples gets at least two shards, since data loaders assign shards to workers.
// With `output.shuffle`, the samples of each shard are chosen from the split at random, with the pipeline's seed.
std::vector<ShardJob> shardJobs(const Plan& plan);

// Returns the splits of these shards with their numbers of shards.
std::vector<DatasetPlan::Split> splitsOf(const std::vector<ShardJob>& jobs);

// Returns the description of a plan that is stored with each part of a dataset. The description's hash identifies the
// dataset. The hash covers the program's version, the pipeline, the sensors and their beams, the scene files, the
// vehicle and the ontology that the pipeline names, and the names and sizes of a recording's files. Files that scene
// files name (assets, ontologies, materials) are not covered: requireUnchangedFiles() compares them.
DatasetPlan datasetPlan(const Plan& plan, const std::vector<ShardJob>& jobs);

}  // namespace scanmill
