#pragma once

// Makes the samples of a dataset: loads the scenes, traces the shots of all sensors of a frame, makes their scans,
// lists the objects that the sensors see, labels voxels, and encodes all of these.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/recently_used.h"
#include "base/stage_clock.h"
#include "dataset/objects.h"
#include "dataset/parts.h"
#include "dataset/shard_writer.h"
#include "dataset/voxels.h"
#include "methods/method.h"
#include "methods/ray_tracing/unobstructed.h"
#include "pipeline/plan/plan.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/recorder.h"
#include "pipeline/run/run_shot.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/scene.h"
#include "scene/thing_boxes.h"
#include "scene/voxels.h"
#include "sense/returns.h"
#include "sensors/beam_grid.h"
#include "sensors/shot.h"

namespace scanmill {

// The object instances of a scene, and the data for tests of their visibility. Safe to use from several threads.
class SceneObjects {
 public:
  // Visibility is tested in the ray-tracing hierarchies (Worlds) of the method; if the method has none, this object
  // builds its own. Scene and method must outlive this object. Throws InputError if `listed` names a class that the
  // scene's ontology does not have.
  SceneObjects(const Scene& scene, const Method& method, const ListedObjects& listed);

  // Returns the boxes of the objects that are listed.
  const ThingBoxes& boxes() const { return boxes_; }
  // Returns the ids of the classes of these objects; empty: all.
  const std::vector<std::uint16_t>& classes() const { return classes_; }
  const Unobstructed& unobstructed() const { return unobstructed_; }
  // Returns the size (bytes) of the hierarchies that this object has built; 0 if it uses the method's hierarchies.
  std::uint64_t memoryBytes() const { return own_ == nullptr ? 0 : own_->memoryBytes(); }
  std::shared_ptr<const BeamGrid> gridOf(const std::shared_ptr<const BeamTable>& beams) const;

 private:
  struct Grid {
    std::shared_ptr<const BeamTable> beams;
    std::shared_ptr<const BeamGrid> grid;
  };

  std::vector<std::uint16_t> classes_;
  ThingBoxes boxes_;
  std::unique_ptr<const Worlds> own_;  // null: the method's Worlds are used
  Unobstructed unobstructed_;
  mutable std::mutex mutex_;
  mutable RecentlyUsed<Grid> grids_;
};

// The object list of one sample.
class ObjectList {
 public:
  // `time`: the time of the sample (s since the start of the sequence), for which the boxes are computed. `placed`: see
  // Shot::placed.
  ObjectList(const SceneObjects& objects, std::string key, double time, std::shared_ptr<const Placements> placed);

  // Adds what a shot sees of each object that it hits or has within the sensor's range. `hits`, `returns`: the hits and
  // returns from which the shot's scan was made; hits need the channel Instance. `raysPerBeam`: number of rays per
  // beam; the first ray of each beam is its axis.
  void add(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits, const Returns& returns);

  // Returns the objects that at least one shot hits or has within its sensor's range, sorted by id.
  [[nodiscard]] SampleObjects finish() const;

 private:
  const SceneObjects& objects_;
  std::string key_;
  double time_;
  std::shared_ptr<const Placements> placed_;
  std::vector<OrientedBox> boxes_;              // one per object instance, in the order of SceneObjects::boxes()
  std::vector<std::vector<ObjectView>> views_;  // for each object instance, one view per shot that reaches it
};

// Facts about a scene that are needed after it is unloaded.
struct SceneFacts {
  std::vector<ModelledItem> modelled;  // see modelledOf()
  Ontology ontology;
  std::vector<std::uint16_t> objectClasses;  // see Manifest
  std::vector<FileRecord> files;             // files that the scene was read from
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

// Loads the scene of a sequence, with everything that its samples need except `probe`. Returns the memory (bytes) that
// the scene takes. Throws InputError for scenes and methods that cannot be used.
std::uint64_t loadScene(ShotSource& source, std::size_t sequence, ReadyScene& ready);

// Loads and unloads scenes. Safe to use from several threads: each scene is loaded once, and all threads that need the
// scene share the work of loading it.
class SceneStore {
 public:
  // `loading`: called before a scene is loaded, with the sequence that needs it, on any thread.
  SceneStore(ShotSource& source, std::function<void(const Sequence&)> loading);
  ~SceneStore();
  SceneStore& operator=(SceneStore&&) = delete;  // neither copied nor moved

  // announce() registers a frame that will need the scene of its sequence. release() must be called for each registered
  // frame once it is done or cancelled.
  void announce(std::size_t sequence);
  void release(std::size_t sequence);

  // Returns the scene of a sequence; loads it if needed. The scene stays loaded as long as the returned pointer exists.
  // If more frames of the scene are announced, it stays until another scene needs the memory. Blocks while the scene
  // does not fit into memory beside the scenes in use. A thread that holds a scene must therefore not wait for another
  // thread's enter(): both could deadlock. Also checks the scene and the sequence for warnings(). Throws InputError for
  // scenes and methods that cannot be used.
  std::shared_ptr<const ReadyScene> enter(std::size_t sequence);

  // Adds the account that the method returned for a frame of a sequence to the account of the scene.
  void account(std::size_t sequence, const TraceAccount& account);

  // Returns all warnings without repetitions, in the order of the pipeline's scenes and sequences. Call it after all
  // frames are done.
  std::vector<std::string> warnings() const;
  // Returns the seconds spent in each of the method's own stages; empty if the method has no separate stages.
  StageSeconds methodSeconds() const;
  double setupSeconds() const { return clock_.seconds().at("setup"); }

 private:
  struct Slot;
  // Warnings about a sequence. `loaded`, `ofScene` and `account` are set only for the first sequence of each scene.
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
  // For each sequence, the index of the first sequence with the same scene; this index identifies the scene.
  std::vector<std::size_t> sceneOf_;
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
  TraceAccount account;
};

// What makeSample() uses and calls.
struct SampleWork {
  ShotBuffers& buffers;
  StageClock& clock;
  std::function<void(const Shot&, ShotBuffers&)> take;  // called with each shot, after its scan is encoded
  bool encodes = true;                                  // false: the sample has no files of scans and voxels
};

// Makes the sample of a frame: traces its shots, makes their scans, lists the objects that the sensors see, labels
// voxels, and encodes all of these.
MadeSample makeSample(const Plan& plan, const ReadyScene& scene, const Sequence& sequence, const Frame& frame,
                      const SampleWork& work);

// Makes samples and records their hits. Safe to use from several threads at once.
class SampleMaker {
 public:
  // `keepHits`: folder for a recording; an empty path means no recording. `overwrite`: replaces an existing recording.
  // `loading`: see SceneStore.
  SampleMaker(ShotSource& source, std::filesystem::path keepHits, bool overwrite,
              std::function<void(const Sequence&)> loading);

  // Makes a sample, then calls scenes().release() for its sequence. The frame need not have been announced.
  MadeSample make(const SampleAddress& address);

  // Completes the recording. Call it after all samples are made.
  void finish() { recorder_.finish(); }
  SceneStore& scenes() { return scenes_; }
  // Returns the time of each stage (s): wall-clock time of stages that wait for a GPU or another process, CPU time of
  // all others.
  StageSeconds stageSeconds() const;

 private:
  std::unique_ptr<ShotBuffers> takeBuffers();

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

// Returns the voxels of a scan. `labels`: the labels of the grid, whose frame is the sensor's frame at the start of the
// revolution. `hits`: the hits from which the scan was made. `raysPerBeam`: number of rays per beam; the first ray of
// each beam is its axis.
//
// - `input` is set for voxels that contain points of the scan, after all effects. The points of a moving sensor are
//   transformed from the sensor's frame at the time of their column to the grid's frame; if the scan is dense, it needs
//   the column `column` for this. Deskewed points are in the grid's frame already.
// - `unseen` is set for voxels that no beam's axis passes through or ends in, empty or not. The axis goes from the
//   sensor, at the time when the beam fires, to the first hit; if the beam has a single ray, it continues through clear
//   glass. If there is no hit, the axis goes to the sensor's maximum range, even if a surface nearer than the minimum
//   range may block the beam. Beams that are unresolved, or without a hit because of the ego vehicle, are ignored.
// - `invalid` is set for unseen voxels that no sensor could see, and for voxels whose surfaces have no class. An empty
//   voxel is called open if a chain of empty voxels that share faces connects it to a voxel that a beam passes through.
//   Unseen empty voxels are invalid if they are not open: they are under ground or inside of closed solids. Unseen
//   voxels with surfaces are invalid if none of the voxels that share a face with them is open: they are inside of
//   objects. Voxels with surfaces without a class are invalid since their label would say that they are empty.
ScanVoxels viewVoxels(const VoxelGrid& grid, VoxelLabels labels, const Shot& shot, std::uint32_t raysPerBeam,
                      const Hits& hits, const Scan& scan);

}  // namespace scanmill
