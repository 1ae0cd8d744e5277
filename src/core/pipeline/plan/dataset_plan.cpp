#include "pipeline/plan/dataset_plan.h"

#include <fmt/core.h>

#include <string>

#include "base/error.h"
#include "base/file.h"
#include "config/resources.h"
#include "config/version.h"
#include "dataset/names.h"
#include "pipeline/plan/shard_jobs.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Throws InputError if the plan has other samples or shards than the dataset.
void checkShards(const Plan& plan, const Manifest& manifest, const fs::path& datasetFolder) {
  const auto refuse = [&](const std::string& difference) {
    throw InputError({(datasetFolder / kManifestName).string()},
                     "its pipeline now gives {}: files that it names or the program (then {}) have changed "
                     "since, or the dataset was made from a recording",
                     difference, manifest.programVersion);
  };
  const std::vector<ShardJob> jobs = shardJobs(plan);
  if (manifest.programVersion == kVersion && datasetPlan(plan, jobs).hash != manifest.planSha256) {
    refuse("other samples");
  }
  if (jobs.size() != manifest.shards.size()) refuse(fmt::format("{} shards", jobs.size()));
  std::vector<std::vector<std::string>> keysByShard(jobs.size());
  for (const SampleRecord& sample : manifest.samples) {
    if (!sample.key.empty()) keysByShard[sample.shard].push_back(sample.key);
  }
  for (std::size_t job = 0; job < jobs.size(); ++job) {
    if (jobs[job].file != manifest.shards[job].file) refuse("the shard " + jobs[job].file);
    if (keysByShard[job].empty()) continue;  // the file that describes the shard's samples is damaged
    if (jobs[job].samples.size() != keysByShard[job].size()) refuse("other samples in " + jobs[job].file);
    for (std::size_t i = 0; i < keysByShard[job].size(); ++i) {
      const SampleAddress& sample = jobs[job].samples[i];
      const std::string key = plan.pipeline.sequences[sample.sequence].key(sample.frame);
      if (key != keysByShard[job][i]) refuse("the sample " + key);
    }
  }
}

}  // namespace

std::vector<fs::path> pipelineFolders(const fs::path& datasetFolder) {
  std::vector<fs::path> folders{{}, datasetFolder};
  std::error_code ignored;
  for (fs::path folder = fs::absolute(datasetFolder, ignored).lexically_normal(); folder.has_relative_path();) {
    folder = folder.parent_path();
    for (const char* subfolder : {"", "pipelines", "scenes"}) folders.push_back(folder / subfolder);
  }
  const fs::path resources = resourceFolder();
  for (const char* subfolder : {"pipelines", "scenes", ""}) folders.push_back(resources / subfolder);
  return folders;
}

Plan planOfDataset(const Manifest& manifest, const fs::path& datasetFolder, const fs::path& pipeline) {
  // A pipeline without the key `name` is named after its file. The path that readPipelineText() gets must therefore end
  // in the dataset's name.
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
    bool hasAllFiles = false;
    try {
      Plan plan = planAt(folder);
      hasAllFiles = true;
      checkShards(plan, manifest, datasetFolder);
      return plan;
    } catch (const InputError& error) {
      std::string& message = hasAllFiles ? different : notFound;
      if (message.empty()) message = error.what();
    }
  }
  throw InputError(fmt::format("{}\nname the pipeline file that {} was made from, by --pipeline FILE",
                               different.empty() ? notFound : different, datasetFolder.string()));
}

}  // namespace scanmill
