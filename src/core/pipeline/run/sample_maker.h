#pragma once

// Makes the samples of a dataset: traces the shots of all sensors of a frame, makes their scans and encodes these.

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/parts.h"
#include "dataset/shard_writer.h"
#include "pipeline/plan/plan.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/recorder.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/run/scene_store.h"

namespace scanmill {

// Returns a manifest with everything that is known before the first ray is traced.
Manifest startManifest(const ShotSource& source, const DatasetPlan& planned);

struct MadeSample {
  Sample sample;
  std::shared_ptr<const SceneFacts> scene;
};

// Makes samples and records their hits. Safe to use from several threads at once.
class SampleMaker {
 public:
  // `keepHits`: folder for a recording; an empty path means no recording. `overwrite`: replaces an existing recording.
  // `loading`: see SceneStore.
  SampleMaker(ShotSource& source, std::filesystem::path keepHits, bool overwrite,
              std::function<void(const Sequence&)> loading);

  // Makes a sample and releases its sequence in scenes(); samples may also be made without announcement.
  MadeSample make(const SampleAddress& address);

  // Completes the recording. Call it after all samples are made.
  void finish() { recorder_.finish(); }
  SceneStore& scenes() { return scenes_; }
  // Returns the processor time of each stage (s); of stages that wait for a graphics card or for another process, the
  // wall-clock time.
  StageSeconds stageSeconds() const;

 private:
  std::unique_ptr<ShotBuffers> takeBuffers();
  void addFormats(const Scan& scan, Sample& sample);
  void addVoxels(const SceneVoxels& voxels, const Shot& shot, const ShotBuffers& buffers, Sample& sample);

  ShotSource& source_;
  const Plan& plan_;
  std::filesystem::path keepHits_;
  bool overwrite_;
  SceneStore scenes_;
  Recorder recorder_;
  std::once_flag opened_;  // the recorder is opened once, by the first call of make()
  std::mutex idleMutex_;
  std::vector<std::unique_ptr<ShotBuffers>> idle_;  // reused for later frames, so that memory use stays constant
  StageClock clock_;
};

}  // namespace scanmill
