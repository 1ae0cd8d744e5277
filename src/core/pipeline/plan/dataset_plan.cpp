#include "pipeline/plan/dataset_plan.h"

#include <fmt/core.h>

#include <string>
#include <utility>

#include "base/error.h"
#include "config/resources.h"
#include "config/version.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/shard_jobs.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Makes the plan of the pipeline whose text is in the manifest. `file`: the path that is assumed for the pipeline;
// relative paths in the text start at the folder of `file`.
Plan planAt(const Manifest& manifest, const fs::path& file) {
  Plan plan = makePlan(readPipelineText(manifest.pipelineText, file));
  if (plan.pipeline.method.automatic && manifest.chosen) return chosenAgain(plan, *manifest.chosen);
  return plan;
}

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

Plan chosenAgain(const Plan& plan, const MethodRecord& chosen) {
  const Pipeline& pipeline = plan.pipeline;
  const std::string text =
      fmt::format("{}{}# --set {}\n", pipeline.text, pipeline.text.ends_with('\n') ? "" : "\n", chosen.assignment);
  return settled(plan, readPipelineText(text, pipeline.file).method, chosen);
}

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
  if (!pipeline.empty()) {
    Plan plan = planAt(manifest, pipeline.parent_path() / name);
    checkShards(plan, manifest, datasetFolder);
    return plan;
  }
  std::string notFound;   // the message about the first folder in which a file is missing
  std::string different;  // the message about the first folder that has all files but gives a different dataset
  for (const fs::path& folder : pipelineFolders(datasetFolder)) {
    bool found = false;
    try {
      Plan plan = planAt(manifest, folder / name);
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
