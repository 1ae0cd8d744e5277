#pragma once

// Which samples a shard holds: it follows from the plan alone, so that any thread, process or machine may make any
// shard, in any order.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/parts.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

struct SampleAddress {
  std::size_t sequence = 0;  // of the pipeline
  std::uint32_t frame = 0;
  std::uint64_t number = 0;  // among all samples of the plan, in the order of sequences and frames
};

struct ShardJob {
  std::string file;  // relative to the dataset's folder, see shardName()
  std::string split;
  std::vector<SampleAddress> samples;  // in the order of sequences and frames
};

// All shards, split by split. A shard holds `output.shard_samples` samples, the last of a split what is left; without
// that key, the samples of a split are shared out evenly over so many shards that none can exceed `output.shard_mb`,
// whatever the beams meet, but at least two where there are two samples, since loaders give each worker a shard. With
// `output.shuffle`, which samples of a split share a shard is drawn at random from the pipeline's seed.
std::vector<ShardJob> shardJobs(const Plan& plan);

// What parts of a dataset say of their plan. Its hash differs where datasets would differ: it is of the program's
// version, the pipeline and the chosen method, the sensors and their beams, the scene files, vehicle and ontology that
// the pipeline names, and the names and sizes of a recording's files. What scenes name (assets, ontologies, materials)
// is not read: whoever changes it begins anew.
DatasetPlan datasetPlan(const Plan& plan, const std::vector<ShardJob>& jobs);

}  // namespace scanmill
