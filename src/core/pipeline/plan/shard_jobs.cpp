#include "pipeline/plan/shard_jobs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dataset/shard.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/dataset_size.h"

namespace scanmill {

std::vector<ShardJob> shardJobs(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline();
  std::vector<std::pair<std::string, std::vector<SampleAddress>>> splits;  // in the order of their first sequences
  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    const Sequence& sequence = pipeline.sequences[s];
    auto split =
        std::find_if(splits.begin(), splits.end(), [&](const auto& known) { return known.first == sequence.split; });
    if (split == splits.end()) split = splits.emplace(splits.end(), sequence.split, std::vector<SampleAddress>{});
    for (std::uint32_t frame = 0; frame < sequence.frames; ++frame) split->second.push_back({s, frame});
  }
  const double room = static_cast<double>(pipeline.shardBytes) - ShardFile::kEndBytes;
  const auto fit = static_cast<std::size_t>(std::max(1.0, std::floor(room / mostSampleBytes(plan))));
  std::vector<ShardJob> jobs;
  for (const auto& [name, samples] : splits) {
    const std::size_t all = samples.size();
    const std::size_t given = pipeline.shardSamples;
    const std::size_t count =
        given > 0 ? (all + given - 1) / given : std::max((all + fit - 1) / fit, std::min<std::size_t>(2, all));
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t first = given > 0 ? i * given : all * i / count;
      const std::size_t last = given > 0 ? std::min(all, first + given) : all * (i + 1) / count;
      ShardJob job{shardName(name, i), name, {}};
      job.samples.assign(samples.begin() + static_cast<std::ptrdiff_t>(first),
                         samples.begin() + static_cast<std::ptrdiff_t>(last));
      jobs.push_back(std::move(job));
    }
  }
  return jobs;
}

}  // namespace scanmill
