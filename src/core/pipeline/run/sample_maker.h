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

// Where samples come from, and what was recorded meanwhile. Safe to use from several threads at once.
class SampleMaker {
 public:
  // Recordings go to the folders that are not empty. `loading`: see SceneStore.
  SampleMaker(ShotSource& source, std::filesystem::path keepHits, std::filesystem::path keepPasses, bool overwrite,
              std::function<void(const Sequence&)> loading);

  // Says which samples will be made, so that scenes go when they are no longer needed, and which of them will not be
  // made after all. Others may be made as well.
  void expect(const SampleAddress& address) { scenes_.expect(address.sequence); }
  void leaveOut(const SampleAddress& address) { scenes_.leave(address.sequence); }

  // Sets up the scene of a sequence; make() does so otherwise.
  void prepare(std::size_t sequence) { scenes_.enter(sequence); }
  MadeSample make(const SampleAddress& address);

  // Once all are made: ends the recordings.
  void finish();
  const SceneStore& scenes() const { return scenes_; }
  // Threads run each stage's work by themselves, but for tracing, which may be helped by idle ones; so what this adds
  // up is close to, not exactly, the time on processors.
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
  std::once_flag opened_;  // the recorder
  BufferPool<ShotBuffers> buffers_;
  StageClock clock_;
};

}  // namespace scanmill
