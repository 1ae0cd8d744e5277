#pragma once

// Makes the samples of a dataset: loads the scenes, traces the shots of all sensors of a frame, makes their scans and
// encodes these.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/parts.h"
#include "dataset/shard_writer.h"
#include "methods/method.h"
#include "pipeline/plan/plan.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/object_list.h"
#include "pipeline/run/recorder.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "scene/scene.h"
#include "scene/voxels.h"

namespace scanmill {

// Facts about a scene that are needed after it is unloaded.
struct SceneFacts {
  std::vector<ModelledItem> modelled;  // see modelledOf()
  Ontology ontology;
  std::vector<FileRecord> files;  // files that the scene was read from
};

// A loaded scene and the method that traces it.
struct ReadyScene {
  Scene scene;
  std::unique_ptr<Method> method;
  std::shared_ptr<const SceneFacts> facts;
  std::optional<SceneProbe> probe;        // nothing if the pipeline has a recording
  std::unique_ptr<SceneObjects> objects;  // null if the pipeline does not write object lists
  std::unique_ptr<SceneVoxels> voxels;    // null if the pipeline does not write voxels
};

// Loads and unloads scenes. Safe to use from several threads at once; threads that need the same scene load it
// together.
class SceneStore {
 public:
  // `loading`: called before a scene is loaded, with the sequence that needs it, on any thread.
  SceneStore(ShotSource& source, std::function<void(const Sequence&)> loading);
  ~SceneStore();
  SceneStore(const SceneStore&) = delete;
  SceneStore& operator=(const SceneStore&) = delete;

  // announce() announces a frame of the sequence. release() must be called for each announced frame once it is done or
  // cancelled.
  void announce(std::size_t sequence);
  void release(std::size_t sequence);

  // Returns the scene of a sequence; loads it if needed. The scene stays loaded as long as the returned pointer exists.
  // If more frames of the scene are announced, it stays until another scene needs the memory. Blocks while the scene
  // does not fit into memory beside the scenes in use. A thread that holds a scene must therefore not wait for another
  // thread's enter(): both could deadlock. Also checks the scene and the sequence for warnings(). Throws InputError for
  // scenes and methods that cannot be used.
  std::shared_ptr<const ReadyScene> enter(std::size_t sequence);

  // Adds the method's account of a frame of a sequence to the account of the scene.
  void account(std::size_t sequence, const TraceAccount& account);

  // Returns all warnings without repetitions, in the order of the pipeline's scenes and sequences. Call it after all
  // frames are done.
  std::vector<std::string> warnings() const;
  // Returns the seconds spent in each of the method's own stages; empty if the method has no separate stages.
  StageSeconds methodSeconds() const;
  double setupSeconds() const;

 private:
  struct Slot;
  // Warnings about a sequence. The first sequence of each scene also has the warnings and the account of its scene.
  struct SceneWarnings {
    bool loaded = false;       // the scene was loaded at least once
    bool pathChecked = false;  // the trajectory was checked for warnings
    std::vector<std::string> ofScene;
    std::vector<std::string> ofPath;
    TraceAccount account;
  };

  std::shared_ptr<Slot> slotOf(std::size_t scene);
  bool fitsOneMore() const;
  void load(std::size_t sequence, Slot& slot);
  void checkPath(std::size_t sequence, const ReadyScene& ready);

  ShotSource& source_;
  const Plan& plan_;
  std::function<void(const Sequence&)> loading_;
  std::vector<std::size_t> sceneOf_;  // for each sequence, the index of the first sequence with the same scene; this
                                      // index identifies the scene
  mutable std::mutex mutex_;
  std::map<std::size_t, std::shared_ptr<Slot>> slots_;    // keys: the indices of scenes that sceneOf_ contains
  std::vector<SceneWarnings> reported_;                   // indexed by the values of sceneOf_
  std::map<std::size_t, std::uint64_t> announcedFrames_;  // numbers of announced frames that are not done, by scene
  std::uint64_t uses_ = 0;
  std::uint64_t largest_ = 0;  // size of the largest scene so far in bytes, including what its method has built
  StageClock clock_;
};

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
