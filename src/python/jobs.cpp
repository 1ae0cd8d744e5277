// Makes, plans, checks and exports datasets for Python. What takes long is a Job on a thread of its own, so that Python
// can show how far it is and stop it.

#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "config/resources.h"
#include "dataset/folder_contents.h"
#include "dataset/verify.h"
#include "exports/export.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/generate.h"
#include "pipeline/scenes/shot_source.h"
#include "python/arrays.h"

namespace py = pybind11;

namespace scanmill {
namespace {

class Job {
 public:
  using Lines = std::vector<std::string>;

  explicit Job(std::function<Lines(Job&)> work)
      : ended_(std::async(std::launch::async, [this, work = std::move(work)] {
          const WarningReceiver receiver([&](const std::string& line) {
            const std::scoped_lock lock(mutex_);
            if (std::ranges::find(warnings_, line) == warnings_.end()) warnings_.push_back(line);
          });
          return work(*this);
        })) {}
  ~Job() {
    stop();
    const py::gil_scoped_release released;
    ended_.wait();
  }
  Job& operator=(Job&&) = delete;  // neither copied nor moved

  // Waits until the work has ended, `seconds` at most. Returns true if it has ended.
  bool wait(double seconds) const {
    const py::gil_scoped_release released;
    return ended_.wait_for(std::chrono::duration<double>(seconds)) == std::future_status::ready;
  }
  // Waits for the end of the work. Returns the problems that it has found, or throws what it has thrown.
  Lines result() const {
    const py::gil_scoped_release released;
    return ended_.get();
  }

  void stop() { stopped_ = true; }
  const std::atomic<bool>& stopped() const { return stopped_; }

  // What is done of how much, as the work's stage counts it.
  void report(const std::string& stage, std::uint64_t done, std::uint64_t all) {
    const std::scoped_lock lock(mutex_);
    progress_ = {stage, done, all};
  }
  std::tuple<std::string, std::uint64_t, std::uint64_t> progress() {
    const std::scoped_lock lock(mutex_);
    return progress_;
  }
  Lines warnings() {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }

 private:
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;  // guards the next two
  std::tuple<std::string, std::uint64_t, std::uint64_t> progress_;
  Lines warnings_;
  std::shared_future<Lines> ended_;  // last: its thread uses the members above
};

// Reads a pipeline: by the path of a file, by the name of one that comes with the program, or from a text, whose
// relative paths start at `here`.
Pipeline pipelineOf(const std::string& pipeline, bool isText, const std::vector<std::string>& overrides,
                    const std::filesystem::path& here) {
  if (isText) {
    std::string text = pipeline + "\n";
    for (const std::string& assignment : overrides) text += "# --set " + assignment + "\n";
    return readPipelineText(text, here / "pipeline.yaml");
  }
  const bool isPath = !isPlainName(pipeline) && pathExists(pipeline);
  return readPipeline(isPath ? std::filesystem::path(pipeline) : namedResource(pipeline, "pipelines"), overrides);
}

// Starts to make a dataset. A complete one of the same plan stays as it is if `resume` is true. `threads`: 0: all
// cores.
std::unique_ptr<Job> startGenerate(const std::string& pipeline, bool isText, const std::vector<std::string>& overrides,
                                   const std::string& here, const std::string& folder, bool overwrite, bool resume,
                                   int threads) {
  return std::make_unique<Job>([=](Job& job) -> Job::Lines {
    std::optional<ThreadLimit> limit;
    if (threads > 0) limit.emplace(threads);
    const Plan plan = makePlan(pipelineOf(pipeline, isText, overrides, here));
    if (resume) {
      if (const auto complete = wholeDatasetOf(datasetPlan(plan, shardJobs(plan)), folder)) {
        requireUnchangedFiles(complete->files, plan.pipeline.file.parent_path(), folder);
        return {};
      }
    }
    const GenerateSummary made =
        generate(plan, {.folder = folder,
                        .overwrite = overwrite,
                        .resume = resume,
                        .quiet = true,
                        .progress = [&](std::uint64_t done, std::uint64_t all) { job.report("frames", done, all); },
                        .stop = &job.stopped()});
    for (const std::string& line : made.warnings) warn(line);
    return {};
  });
}

std::unique_ptr<Job> startExport(const std::string& dataset, const std::string& layout, const std::string& folder,
                                 const std::string& classes, const std::vector<std::string>& sensors,
                                 const std::vector<std::string>& splits, bool overwrite) {
  return std::make_unique<Job>([=](Job& job) {
    requireDataset(dataset);
    ExportOptions options;
    options.dataset = dataset;
    options.layout = &requireLayout(layout);
    options.folder = folder;
    if (!classes.empty()) options.classes = namedResource(classes, "labels");
    options.sensors = sensors;
    options.splits = splits;
    options.overwrite = overwrite;
    options.stop = &job.stopped();
    options.progress = [&](const char* stage, std::uint64_t done, std::uint64_t all) {
      job.report(fmt::format("frames, {}", stage), done, all);
    };
    for (const std::string& line : exportDataset(options).warnings) warn(line);
    return Job::Lines();
  });
}

std::unique_ptr<Job> startVerify(const std::string& dataset) {
  return std::make_unique<Job>([=](Job& job) {
    requireDataset(dataset);
    return verifyDataset(dataset,
                         [&](std::uint64_t done, std::uint64_t all) {
                           if (job.stopped()) throw Error("stopped: not all shards were checked");
                           job.report("shards", done, all);
                         })
        .problems;
  });
}

// Returns what a pipeline makes, as JSON.
std::string planJson(const std::string& pipeline, bool isText, const std::vector<std::string>& overrides,
                     const std::string& here) {
  const py::gil_scoped_release released;
  const Plan plan = makePlan(pipelineOf(pipeline, isText, overrides, here));
  using Json = nlohmann::ordered_json;
  Json json{{"samples", plan.pipeline.frames()}, {"rays", static_cast<std::uint64_t>(plan.pipeline.rays())},
            {"shards", Json::object()},          {"sequences", Json::array()},
            {"modelled", Json::array()},         {"left_out", Json::array()}};
  for (const DatasetPlan::Split& split : splitsOf(shardJobs(plan))) json["shards"][split.name] = split.shards;
  for (const Sequence& s : plan.pipeline.sequences) json["sequences"].push_back(s.key());
  for (const ModelledItem& item : modelled(plan, ShotSource(plan).blockedShares())) {
    json[item.leftOut ? "left_out" : "modelled"].push_back(lineOf(item));
  }
  return json.dump();
}

}  // namespace

void defineJobs(py::module_& module) {
  py::class_<Job>(module, "Job")
      .def("wait", &Job::wait)
      .def("result", &Job::result)
      .def("stop", &Job::stop)
      .def_property_readonly("progress", &Job::progress)
      .def_property_readonly("warnings", &Job::warnings);
  module.def("generate", &startGenerate);
  module.def("export", &startExport);
  module.def("verify", &startVerify);
  module.def("plan", &planJson);
}

}  // namespace scanmill
