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

// What is told of a scene when it is gone.
struct SceneFacts {
  std::vector<std::string> modelled;  // by the method
  Ontology ontology;
};

// A scene and the method that traces it.
struct ReadyScene {
  Scene scene;
  std::unique_ptr<Method> method;
  std::shared_ptr<const SceneFacts> facts;
  std::optional<SceneProbe> probe;        // none for a recording
  std::unique_ptr<SceneObjects> objects;  // null where nobody asks for them
  std::unique_ptr<SceneVoxels> voxels;    // likewise
};

// Safe to use from several threads at once: those that need the same scene load it together.
class SceneStore {
 public:
  // `loading` is called, by any thread, before a scene is loaded for a sequence.
  SceneStore(ShotSource& source, std::function<void(const Sequence&)> loading);
  ~SceneStore();
  SceneStore(const SceneStore&) = delete;
  SceneStore& operator=(const SceneStore&) = delete;

  // A frame of the sequence will be asked for; one that was expected is done, or will not be asked for after all.
  void expect(std::size_t sequence);
  void leave(std::size_t sequence);

  // The scene of a sequence, which stays as long as what is returned does. Scenes that nobody uses stay as well while
  // frames of them are expected and the program takes less than half of the memory that it may take; where it may not
  // take as much as one more scene needs, this waits until those that are in use are given back. Nobody who keeps one
  // may therefore wait for somebody who enters. What is told of scenes and sequences is found here, too. Throws
  // InputError for scenes and methods that cannot be used.
  std::shared_ptr<const ReadyScene> enter(std::size_t sequence);

  // Adds what tracing a frame of a sequence took. Of what its method warns of, all frames of a scene count.
  void account(std::size_t sequence, const TraceAccount& account);

  // Once the work is done: by scenes and sequences in the order of the pipeline, whatever the order they were entered
  // in; no line twice.
  std::vector<std::string> warnings() const;
  // By the method's own stages; empty where it has but one.
  // Who took the shots, where there was a choice (TraceAccount).
  StageSeconds methodSeconds() const;
  double setupSeconds() const;

 private:
  struct Slot;
  // What is told of a sequence, and of the scene that it is the first to have.
  struct Told {
    bool loaded = false;  // the scene, at least once
    bool looked = false;  // whether its way was looked at
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
  std::vector<std::size_t> sceneOf_;  // of each sequence: the first sequence that has its scene
  mutable std::mutex mutex_;
  std::map<std::size_t, std::shared_ptr<Slot>> slots_;  // by scene
  std::vector<Told> told_;                              // by sequence
  std::map<std::size_t, std::uint64_t> expected_;       // frames, by scene
  std::uint64_t uses_ = 0;
  std::uint64_t largest_ = 0;  // bytes, of the scenes that were loaded, with what their methods have made of them
  StageClock clock_;
};

}  // namespace scanmill
