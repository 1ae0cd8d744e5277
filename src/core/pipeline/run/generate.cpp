#include "pipeline/run/generate.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>

#include "base/own_folder.h"
#include "config/resources.h"
#include "dataset/card.h"
#include "dataset/dataset_folder.h"
#include "dataset/folder_contents.h"
#include "dataset/names.h"
#include "dataset/parts.h"
#include "dataset/shard_writer.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/sample_maker.h"
#include "pipeline/run/shard_workers.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

// A shard that is being written.
struct OpenShard {
  OpenShard(const std::filesystem::path& folder, const ShardJob& job, DatasetPart newPart,
            std::unique_ptr<FolderLock> shardLock)
      : claim(std::move(shardLock)),
        writer(folder, job.file, job.split),
        part(std::move(newPart)),
        samples(job.samples.size()) {}

  // This process's lock on the shard; null if the folder is not shared with other processes.
  std::unique_ptr<FolderLock> claim;
  ShardWriter writer;
  DatasetPart part;
  // The samples by their position in the shard; null: the sample is not made yet, or is written already.
  std::vector<std::unique_ptr<MadeSample>> samples;
  std::shared_ptr<const SceneFacts> scene;  // the scene of the sample that was written last
};

// Makes the shards of one generate() call. open(), make(), write() and close() are called as ShardWork says.
class DatasetRun {
 public:
  DatasetRun(ShotSource& source, const GenerateOptions& options)
      : plan_(source.plan()),
        pipeline_(plan_.pipeline),
        options_(options),
        jobs_(shardJobs(plan_)),
        planned_(datasetPlan(plan_, jobs_)),
        folder_(options.folder, options.use(), planned_),
        base_(startManifest(source, planned_)),
        raysPerSample_(pipeline_.rays() / static_cast<double>(pipeline_.frames())),
        open_(jobs_.size()),
        files_(base_.files),
        progress_("generate", 0, "frames", "rays", options.quiet),
        maker_(source, options.keepHits, options.overwrite,
               [this](const Sequence& sequence) { showStage("setting up " + sequence.key()); }) {
    summary_.manifest = base_;
  }

  // Makes the shards that this process has to make, waits for shards that other processes make, and writes the manifest
  // if the dataset is then complete.
  GenerateSummary run() {
    if (folder_.isComplete()) return summaryOfComplete();
    checkFiles();
    std::vector<std::size_t> pending = chosenJobs();
    while (!pending.empty()) {
      workOnShards(pending.size(), plan_.framesInFlight(), options_.stop,
                   {.open = [&](std::size_t i) { return open(pending[i]); },
                    .make = [&](std::size_t i, std::size_t sample) { make(pending[i], sample); },
                    .take = [&](std::size_t i, std::size_t sample) { write(pending[i], sample); },
                    .close = [&](std::size_t i) { close(pending[i]); }});
      checkStop();
      pending = std::exchange(madeByOthers_, {});
      if (!pending.empty()) waitForOthers(pending.size());
    }
    return finish();
  }

 private:
  // Returns the indices of the shards that this process may have to make, and announces their samples.
  std::vector<std::size_t> chosenJobs() {
    std::vector<std::size_t> chosen(options_.shards.listed.begin(), options_.shards.listed.end());
    if (options_.shards.kind != ShardChoice::Kind::Listed) {
      chosen.resize(jobs_.size());
      std::iota(chosen.begin(), chosen.end(), std::size_t{0});
    }
    std::uint64_t frames = 0;
    for (const std::size_t job : chosen) {
      frames += jobs_[job].samples.size();
      for (const SampleAddress& sample : jobs_[job].samples) maker_.scenes().announce(sample.sequence);
    }
    progress_.setTotal(frames);
    return chosen;
  }

  // Opens a shard for writing and returns its number of samples; 0 if it is complete, or if another process makes it.
  std::size_t open(std::size_t job) {
    const ShardJob& shard = jobs_[job];
    // Kind::Any checks sizes only: checking bytes would make each process read the shards of all other processes.
    const auto check =
        options_.shards.kind == ShardChoice::Kind::Any ? DatasetFolder::Check::Size : DatasetFolder::Check::Bytes;
    // Claims the shard before looking for its record; otherwise another process could complete the shard in between.
    std::unique_ptr<FolderLock> claim = shared() ? folder_.claim(shard.file) : nullptr;
    if (const std::optional<DatasetPart> complete = folder_.findRecord(shard.file, check)) {
      for (const SampleAddress& sample : shard.samples) maker_.scenes().release(sample.sequence);
      const std::scoped_lock lock(mutex_);
      count(complete->manifest);
      ++summary_.resumedShards;
      advance(shard.samples.size());
      return 0;
    }
    if (shared() && claim == nullptr) {
      const std::scoped_lock lock(mutex_);
      madeByOthers_.push_back(job);
      return 0;
    }
    folder_.requireSameFolder();  // throws if the output folder was replaced by another folder meanwhile
    DatasetPart part{planned_.hash, {}, base_};
    part.manifest.sequences.clear();
    for (const SampleAddress& sample : shard.samples) {
      part.numbers.push_back(sample.number);
      const SequenceRecord& sequence = base_.sequences[sample.sequence];
      std::vector<SequenceRecord>& sequences = part.manifest.sequences;
      if (sequences.empty() || sequences.back() != sequence) sequences.push_back(sequence);
    }
    open_[job] = std::make_unique<OpenShard>(folder_.staging(), shard, std::move(part), std::move(claim));
    return shard.samples.size();
  }

  void make(std::size_t job, std::size_t i) {
    open_[job]->samples[i] = std::make_unique<MadeSample>(maker_.make(jobs_[job].samples[i]));
  }

  // Appends a sample to its shard. If the sample's scene is new, adds the facts about it to the shard's manifest.
  void write(std::size_t job, std::size_t i) {
    const std::unique_ptr<MadeSample> made = std::move(open_[job]->samples[i]);
    {
      const StageTimer timer(clock_, "write");
      open_[job]->writer.add(made->sample);
    }
    Manifest& part = open_[job]->part.manifest;
    if (open_[job]->scene != made->scene) {
      open_[job]->scene = made->scene;
      addItems(made->scene->modelled, part.modelled);
      addFiles(made->scene->files, part.files);
      part.ontology = made->scene->ontology;
      part.objectClasses = made->scene->objectClasses;
      const std::scoped_lock lock(mutex_);
      expectOneVersion(made->scene->files);
    }
    const std::scoped_lock lock(mutex_);
    advance(1);
  }

  void close(std::size_t job) {
    const StageTimer timer(clock_, "write");
    const std::unique_ptr<OpenShard> shard = std::move(open_[job]);
    ShardPart written = shard->writer.finish();
    shard->part.manifest.shards = {std::move(written.shard)};
    shard->part.manifest.samples = std::move(written.samples);
    // Stores the record and reads it again at the end, since the records of all shards might not fit into memory.
    folder_.storeRecord(shard->part);
    const std::scoped_lock lock(mutex_);
    count(shard->part.manifest);
    ++summary_.shards;
    summary_.samplesMade += jobs_[job].samples.size();
  }

  // Throws InputError if complete shards were made from files that have changed since.
  void checkFiles() {
    if (options_.anyFiles) return;
    std::vector<FileRecord> files;
    for (const ShardJob& job : jobs_) {
      if (const auto complete = folder_.findRecord(job.file, DatasetFolder::Check::Size)) {
        addFiles(complete->manifest.files, files);
      }
    }
    requireUnchangedFiles(files, pipeline_.file.parent_path(), options_.folder);
  }

  // Throws InputError if a file of a scene has changed since the pipeline or an earlier scene was read from it.
  void expectOneVersion(const std::vector<FileRecord>& files) {
    const std::string changed = addFiles(files, files_);
    if (changed.empty() || options_.anyFiles) return;
    throw InputError({fileOfSavedPath(changed, pipeline_.file.parent_path()).string()},
                     "changed while the dataset was made: start again with --overwrite, or complete the dataset by "
                     "--resume=anyway");
  }

  // Counts samples that are done. mutex_ must be locked.
  void advance(std::size_t samples) {
    progress_.advance(samples, static_cast<double>(samples) * raysPerSample_);
    if (options_.progress) options_.progress(progress_.done(), progress_.total());
  }

  bool shared() const { return options_.shards.kind != ShardChoice::Kind::All; }

  void checkStop() const {
    if (options_.stop == nullptr || !*options_.stop) return;
    if (!folder_.hasRecords()) throw Error("stopped before a shard was complete: no shard was kept");
    throw Error("stopped: the dataset is unfinished, so the folder has no manifest; {}",
                shared() ? "the same command continues it" : "--resume continues it");
  }

  void waitForOthers(std::size_t shards) {
    showStage(fmt::format("waiting for {} shards that other processes make", shards));
    for (int i = 0; i < 10; ++i) {
      checkStop();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

  void showStage(const std::string& stage) {
    const std::scoped_lock lock(mutex_);
    progress_.say(stage);
  }

  // Returns the summary of a dataset that other processes completed before this process made a shard.
  GenerateSummary summaryOfComplete() {
    std::optional<Manifest> manifest = wholeDatasetOf(planned_, options_.folder);
    if (!manifest) {
      throw InputError(
          {options_.folder.string()},
          "has a complete dataset of another pipeline (another `--set` makes another pipeline), of changed files that "
          "the pipeline names, or of another version of this program: choose another output folder with -o");
    }
    if (!options_.anyFiles) requireUnchangedFiles(manifest->files, pipeline_.file.parent_path(), options_.folder);
    summary_.manifest = std::move(*manifest);
    summary_.complete = true;
    return std::move(summary_);
  }

  // Returns the records of all shards, which must be complete.
  std::vector<DatasetPart> allParts() const {
    std::vector<DatasetPart> parts;
    for (const ShardJob& job : jobs_) {
      std::optional<DatasetPart> part = folder_.findRecord(job.file, DatasetFolder::Check::Size);
      if (!part) {
        throw Error("{} has vanished from {}: --resume makes it again", job.file, folder_.staging().string());
      }
      parts.push_back(std::move(*part));
    }
    return parts;
  }

  // Warns of sensors without any scan or point in a sequence. The manifest has all samples, in the order of sequences.
  void warnOfBlindSensors() {
    auto sample = summary_.manifest.samples.begin();
    for (const Sequence& sequence : pipeline_.sequences) {
      std::map<std::string, std::uint64_t> scans, points;  // by sensor
      for (std::uint32_t frame = 0; frame < sequence.frames; ++frame, ++sample) {
        for (const ScanRecord& scan : sample->scans) {
          ++scans[scan.sensor];
          points[scan.sensor] += scan.points;
        }
      }
      for (const MountedSensor& sensor : pipeline_.sensors) {
        const bool hasScan = scans[sensor.name] > 0;
        if (points[sensor.name] > 0 || (!hasScan && !sensor.choice.empty())) continue;
        summary_.warnings.push_back(fmt::format(
            "sequence {}: the sensor '{}' {} in {} frames: {}", sequence.key(), sensor.name,
            hasScan ? "hits nothing" : "has no scan", sequence.frames,
            hasScan ? "is the trajectory inside the scene?" : "do they take less time than one of its revolutions?"));
      }
    }
  }

  // Warns if a recording, which has one ray per beam, is scanned with effects that trace several rays per beam.
  void warnOfOneRay() {
    const auto tracesSeveral = [](const Effects* e) { return raysPerBeam(*e) > 1 || lightPaths(*e) != nullptr; };
    for (std::size_t s = 0; pipeline_.recording != nullptr && s < pipeline_.sensors.size(); ++s) {
      if (std::ranges::none_of(pipeline_.effectCases(s), tracesSeveral)) continue;
      return summary_.warnings.push_back(
          "the recording has one ray per beam, so the scans are made without the effects footprint and light_paths: "
          "leave these out, or trace the scene again");
    }
  }

  // Adds a shard that this process has made, or has found complete, to the summary.
  void count(const Manifest& part) {
    summary_.manifest.ontology = part.ontology;
    summary_.manifest.objectClasses = part.objectClasses;
    summary_.samples += part.samples.size();
    const ScanTotals totals = totalsOf(part);
    summary_.beams += totals.beams;
    summary_.points += totals.points;
    for (const auto& [id, points] : totals.perClass) summary_.pointsPerClass[id] += points;
    for (const ShardRecord& shard : part.shards) summary_.bytes += shard.bytes;
  }

  // Completes the recording, and the dataset if no other process still makes shards of it.
  GenerateSummary finish() {
    summary_.warnings = maker_.scenes().warnings();
    warnOfOneRay();
    summary_.stages = maker_.stageSeconds();
    addSeconds(clock_.seconds(), summary_.stages);
    maker_.finish();
    summary_.complete = options_.shards.kind != ShardChoice::Kind::Listed && folder_.makeAlone();
    folder_.requireSameFolder();
    if (summary_.complete) {
      summary_.manifest = joinParts(planned_, allParts(), options_.anyFiles);
      warnOfBlindSensors();
      folder_.publish(summary_.manifest);
    }
    summary_.seconds = progress_.seconds();
    summary_.processorSeconds = processSeconds() - started_;
    return std::move(summary_);
  }

  double started_ = processSeconds();
  const Plan& plan_;
  const Pipeline& pipeline_;
  const GenerateOptions& options_;
  std::vector<ShardJob> jobs_;
  DatasetPlan planned_;
  DatasetFolder folder_;
  Manifest base_;  // initial contents of each part's manifest
  const double raysPerSample_;
  std::vector<std::unique_ptr<OpenShard>> open_;  // indexed by job; null: not open
  std::mutex mutex_;                              // guards the members up to progress_
  std::vector<FileRecord> files_;                 // files that the pipeline and the scenes so far were read from
  std::vector<std::size_t> madeByOthers_;         // jobs whose shards other processes are making
  GenerateSummary summary_;
  Progress progress_;
  StageClock clock_;
  SampleMaker maker_;
};

// Throws InputError if two of the folders for the dataset and its recordings are the same, or if one folder is within
// another: --overwrite for one of them could then remove files of the other.
void checkSeparateFolders(const Plan& plan, const GenerateOptions& options) {
  std::vector<std::filesystem::path> folders;
  const std::shared_ptr<const Recording>& recording = plan.pipeline.recording;
  for (const std::filesystem::path& folder :
       {options.folder, options.keepHits, recording == nullptr ? std::filesystem::path() : recording->folder}) {
    if (folder.empty()) continue;
    for (const std::filesystem::path& other : folders) {
      if (!isWithin(folder, other) && !isWithin(other, folder)) continue;
      throw InputError(
          {folder.string()},
          "the dataset and each recording need separate folders: give folders that are not within one another");
    }
    folders.push_back(folder);
  }
}

}  // namespace

std::optional<Manifest> wholeDatasetOf(const DatasetPlan& plan, const std::filesystem::path& folder) {
  std::error_code failure;
  if (isUnfinished(folder) || !std::filesystem::exists(folder / kManifestName, failure)) return {};
  Manifest manifest = readManifest(folder);
  if (manifest.planSha256 != plan.hash) return {};
  DatasetFolder::tidy(folder);
  for (const ShardRecord& shard : manifest.shards) {
    if (std::filesystem::file_size(folder / shard.file, failure) == shard.bytes) continue;
    throw InputError({folder.string()}, "{} is missing or damaged: `scanmill verify {}` says how to make it again",
                     shard.file, folder.string());
  }
  return manifest;
}

GenerateSummary generate(const Plan& plan, const GenerateOptions& options) {
  checkSeparateFolders(plan, options);
  if (!options.keepHits.empty()) {
    plan.requireOneRay();
    if (options.resume) throw InputError("--resume cannot continue a recording: leave out --resume, or --keep-hits");
    if (options.shards.kind != ShardChoice::Kind::All) {
      throw InputError("a recording must be made by one process: leave out --keep-hits, or --shards and --worker");
    }
  }
  ShotSource source(plan);
  return DatasetRun(source, options).run();
}

}  // namespace scanmill
