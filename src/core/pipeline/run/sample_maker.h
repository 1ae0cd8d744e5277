#pragma once

// Makes the samples of a run: all sensors of a frame, traced, sensed and encoded.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>

#include "base/stage_clock.h"
#include "dataset/shard_writer.h"
#include "pipeline/plan/plan.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/buffer_pool.h"
#include "pipeline/run/recorder.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/run/scene_store.h"

namespace scanmill {

struct MadeSample {
  Sample sample;
  std::shared_ptr<const SceneFacts> scene;
};

// Makes samples, and writes recordings of their hits or passes. Safe to use from several threads at once.
class SampleMaker {
 public:
  // Recordings are written to the folders whose paths are not empty. `loading`: see SceneStore.
  SampleMaker(ShotSource& source, std::filesystem::path keepHits, std::filesystem::path keepPasses, bool overwrite,
              std::function<void(const Sequence&)> loading);

  // expect() announces a sample that will be made, leaveOut() takes an announcement back. A scene is unloaded after its
  // last announced sample. Samples that were not announced may be made as well.
  void expect(const SampleAddress& address) { scenes_.expect(address.sequence); }
  void leaveOut(const SampleAddress& address) { scenes_.leave(address.sequence); }

  // Sets up the scene of a sequence now; otherwise make() does it.
  void prepare(std::size_t sequence) { scenes_.enter(sequence); }
  MadeSample make(const SampleAddress& address);

  // Ends the recordings. Call it after all samples are made.
  void finish();
  const SceneStore& scenes() const { return scenes_; }
  // Returns the time of each stage, added up over threads. It is close to the processor time, but not equal: each stage
  // runs on one thread, except that idle threads may help with tracing.
  StageSeconds stageSeconds() const;

 private:
  void addFormats(const Scan& scan, Sample& sample);
  void addVoxels(const SceneVoxels& voxels, const Shot& shot, const ShotBuffers& buffers, Sample& sample);
  TraceAccount drawAndRecord(const ReadyScene& ready, const Shot& shot, Hits& hits);

  ShotSource& source_;
  const Plan& plan_;
  std::filesystem::path keepHits_, keepPasses_;
  bool overwrite_;
  SceneStore scenes_;
  Recorder recorder_;
  std::once_flag opened_;  // for opening the recorder
  BufferPool<ShotBuffers> buffers_;
  StageClock clock_;
};

}  // namespace scanmill
