#pragma once

// The scenes of a run, loaded when a frame needs them.

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/method.h"
#include "pipeline/run/object_list.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "scene/scene.h"
#include "scene/voxels.h"

namespace scanmill {

// Facts about a scene that are needed after it is unloaded.
struct SceneFacts {
  std::vector<std::string> modelled;  // see Method::modelled()
  Ontology ontology;
};

// A scene and the method that traces it.
struct ReadyScene {
  Scene scene;
  std::unique_ptr<Method> method;
  std::shared_ptr<const SceneFacts> facts;
  std::optional<SceneProbe> probe;        // none for a recording
  std::unique_ptr<SceneObjects> objects;  // null if the output has no objects
  std::unique_ptr<SceneVoxels> voxels;    // null if the output has no voxels
};

// Safe to use from several threads at once; threads that need the same scene load it together.
class SceneStore {
 public:
  // `loading` is called, by any thread, before a scene is loaded for a sequence.
  SceneStore(ShotSource& source, std::function<void(const Sequence&)> loading);
  ~SceneStore();
  SceneStore(const SceneStore&) = delete;
  SceneStore& operator=(const SceneStore&) = delete;

  // expect() announces a frame of the sequence; leave() says that an announced frame is done or will not be made.
  void expect(std::size_t sequence);
  void leave(std::size_t sequence);

  // Returns the scene of a sequence, which stays loaded as long as the returned pointer exists. Unused scenes stay
  // loaded while frames of them are expected and the program takes less than half of its memory limit. If one more
  // scene would exceed the limit, waits until scenes in use are released; holding a scene while waiting for another
  // thread's enter() therefore deadlocks. Also checks the scene and the sequence, for warnings(). Throws InputError for
  // scenes and methods that cannot be used.
  std::shared_ptr<const ReadyScene> enter(std::size_t sequence);

  // Adds the account of tracing a frame of a sequence. The accounts of all frames of a scene are added up.
  void account(std::size_t sequence, const TraceAccount& account);

  // Returns the warnings, each once, in the order of the pipeline's scenes and sequences, whatever the order in which
  // they were entered. Call it after the work is done.
  std::vector<std::string> warnings() const;
  // Returns the times of the method's own stages; empty if it has only one.
  StageSeconds methodSeconds() const;
  double setupSeconds() const;

 private:
  struct Slot;
  // Warnings about a sequence, and about its scene if it is the first sequence with this scene.
  struct Told {
    bool loaded = false;  // the scene was loaded at least once
    bool looked = false;  // the trajectory was checked
    std::vector<std::string> ofScene;
    std::vector<std::string> ofWay;
    TraceAccount account;
  };

  std::shared_ptr<Slot> slotOf(std::size_t scene);
  bool fitsOneMore() const;
  void load(std::size_t sequence, Slot& slot);
  void lookAtWay(std::size_t sequence, const ReadyScene& ready);

  ShotSource& source_;
  const Plan& plan_;
  std::function<void(const Sequence&)> loading_;
  std::vector<std::size_t> sceneOf_;  // for each sequence, the first sequence with the same scene
  mutable std::mutex mutex_;
  std::map<std::size_t, std::shared_ptr<Slot>> slots_;  // by scene
  std::vector<Told> told_;                              // by sequence
  std::map<std::size_t, std::uint64_t> expected_;       // number of frames, by scene
  std::uint64_t uses_ = 0;
  std::uint64_t largest_ = 0;  // bytes of the largest scene so far, including what its method has built
  StageClock clock_;
};

}  // namespace scanmill
