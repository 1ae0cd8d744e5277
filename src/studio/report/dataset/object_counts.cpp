#include "report/dataset/object_counts.h"

#include <algorithm>
#include <memory>

#include "base/error.h"
#include "dataset/objects.h"
#include "dataset/shard_index.h"

namespace scanmill {

namespace {

std::size_t visibilityStep(const ObjectView& view) {
  if (view.points == 0) return 0;
  const double visibility = view.visibility().value_or(0);
  return visibility <= 0.4 ? 1 : visibility <= 0.6 ? 2 : visibility <= 0.8 ? 3 : 4;
}

}  // namespace

ObjectCounts countObjects(const std::filesystem::path& folder, const Manifest& manifest,
                          const std::vector<std::size_t>& samples, std::vector<std::string>& faults) {
  ObjectCounts counts;
  std::unique_ptr<const ShardIndex> shard;
  for (const std::size_t number : samples) {
    const SampleRecord& sample = manifest.samples[number];
    if (!sample.objects) continue;
    try {
      const std::filesystem::path file = folder / manifest.shards[sample.shard].file;
      if (shard == nullptr || shard->file() != file) {
        shard = std::make_unique<const ShardIndex>(file, DamagedShard::ReadAsFarAsWhole);
      }
      const ShardMember* const member = shard->find(objectsMember(sample.key));
      if (member == nullptr) throw InputError({file.string()}, "lacks the member " + objectsMember(sample.key));
      for (const ObjectRecord& object : parseObjects(shard->read(*member), member->name, manifest.ontology).objects) {
        for (const ObjectView& view : object.views) {
          const std::size_t step = visibilityStep(view);
          ++counts.ofClass[object.semantic][step];
          const double distance = length(view.sensorFromBox.translation);
          const auto band = std::upper_bound(kDistanceSteps.begin(), kDistanceSteps.end(), distance);
          ++counts.ofDistance[static_cast<std::size_t>(band - kDistanceSteps.begin())][step];
        }
      }
      ++counts.samples;
    } catch (const InputError& error) {
      faults.emplace_back(error.what());
      shard.reset();
    }
  }
  return counts;
}

}  // namespace scanmill
