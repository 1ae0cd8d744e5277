#include "pipeline/plan/dataset_plan.h"

#include <fmt/core.h>

#include <string>

#include "base/error.h"
#include "config/resources.h"
#include "config/version.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/shard_jobs.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

void checkShards(const Plan& plan, const Manifest& manifest, const fs::path& datasetFolder) {
  const auto differs = [&](const std::string& what) {
    throw InputError({(datasetFolder / kManifestName).string()},
                     fmt::format("its pipeline now gives {}: files that it names or the program (then {}) have changed "
                                 "since, or the dataset was made from a recording",
                                 what, manifest.programVersion));
  };
  const std::vector<ShardJob> jobs = shardJobs(plan);
  if (manifest.programVersion == kVersion && !manifest.planSha256.empty() &&
      datasetPlan(plan, jobs).hash != manifest.planSha256) {
    differs("other samples");
  }
  if (jobs.size() != manifest.shards.size()) differs(fmt::format("{} shards", jobs.size()));
  std::vector<std::vector<std::string>> keys(jobs.size());
  for (const SampleRecord& sample : manifest.samples) {
    if (!sample.key.empty()) keys[sample.shard].push_back(sample.key);
  }
  for (std::size_t job = 0; job < jobs.size(); ++job) {
    if (jobs[job].file != manifest.shards[job].file) differs("the shard " + jobs[job].file);
    if (keys[job].empty()) continue;  // the file that describes the shard's samples is damaged
    if (jobs[job].samples.size() != keys[job].size()) differs("other samples in " + jobs[job].file);
    for (std::size_t i = 0; i < keys[job].size(); ++i) {
      const auto& [sequence, frame, number] = jobs[job].samples[i];
      const std::string key = plan.pipeline.sequences[sequence].key(frame);
      if (key != keys[job][i]) differs("the sample " + key);
    }
  }
}

}  // namespace

std::vector<fs::path> pipelineFolders(const fs::path& datasetFolder) {
  std::vector<fs::path> folders{{}, datasetFolder};
  std::error_code ignored;
  for (fs::path above = fs::absolute(datasetFolder, ignored).lexically_normal(); above.has_relative_path();) {
    above = above.parent_path();
    for (const char* within : {"", "pipelines", "scenes"}) folders.push_back(above / within);
  }
  const fs::path resources = resourceFolder();
  for (const char* within : {"pipelines", "scenes", ""}) folders.push_back(resources / within);
  return folders;
}

Plan planOfDataset(const Manifest& manifest, const fs::path& datasetFolder, const fs::path& pipeline) {
  // A pipeline without the key `name` takes its name from its file's name, so the assumed file must have the dataset's
  // name.
  const std::string name = manifest.name + ".yaml";
  const auto planAt = [&](const fs::path& folder) {
    return makePlan(readPipelineText(manifest.pipelineText, folder / name));
  };
  if (!pipeline.empty()) {
    Plan plan = planAt(pipeline.parent_path());
    checkShards(plan, manifest, datasetFolder);
    return plan;
  }
  std::string notFound;   // the message about the first folder in which a file is missing
  std::string different;  // the message about the first folder that has all files but gives a different dataset
  for (const fs::path& folder : pipelineFolders(datasetFolder)) {
    bool found = false;
    try {
      Plan plan = planAt(folder);
      found = true;
      checkShards(plan, manifest, datasetFolder);
      return plan;
    } catch (const InputError& error) {
      std::string& why = found ? different : notFound;
      if (why.empty()) why = error.what();
    }
  }
  throw InputError(fmt::format("{}\nname the pipeline file that {} was made from, by --pipeline FILE",
                               different.empty() ? notFound : different, datasetFolder.string()));
}

}  // namespace scanmill
