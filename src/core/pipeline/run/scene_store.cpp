#include <tbb/collaborative_call_once.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <list>
#include <thread>
#include <utility>

#include "base/append_new.h"
#include "base/input_budget.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/tsan_order.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/run/sample_maker.h"

namespace scanmill {

namespace {

// While the first scene is loaded, and no scene's size is known yet, further scenes are loaded only if the program
// takes less than 1 / kSmallShare of its memory limit.
constexpr std::uint64_t kSmallShare = 8;

}  // namespace

struct SceneStore::Slot {
  tbb::collaborative_once_flag once;
  TaskOrder loaded;  // tells the thread sanitizer that loading happens before any other use of the scene
  std::exception_ptr failure;
  ReadyScene ready;
  std::uint64_t lastUse = 0;
};

SceneStore::SceneStore(ShotSource& source, std::function<void(const Sequence&)> loading)
    : source_(source),
      plan_(source.plan()),
      loading_(std::move(loading)),
      reported_(plan_.pipeline.sequences.size()),
      clock_({"setup"}) {
  const std::vector<Sequence>& sequences = plan_.pipeline.sequences;
  for (const Sequence& sequence : sequences) {
    const auto first = std::ranges::find_if(sequences, [&](const auto& other) { return other.sameScene(sequence); });
    sceneOf_.push_back(static_cast<std::size_t>(first - sequences.begin()));
  }
}

SceneStore::~SceneStore() = default;

// True if no scene is in use, or if one more scene fits into memory in addition to the scenes in use.
bool SceneStore::fitsOneMore() const {
  const auto usedScenes = std::ranges::count_if(slots_, [](const auto& s) { return s.second.use_count() > 1; });
  if (usedScenes == 0) return true;
  // No size is known: the first scene is still being loaded.
  if (largest_ == 0) return kSmallShare * residentBytes() < memoryLimitBytes();
  return plan_.bytesInMemory(static_cast<std::uint64_t>(usedScenes + 1) * largest_) <= memoryLimitBytes();
}

// Returns a scene's slot. If the scene is not loaded, waits until one more scene fits into memory and adds a slot.
std::shared_ptr<SceneStore::Slot> SceneStore::slotOf(std::size_t scene) {
  std::list<std::shared_ptr<Slot>> unloaded;  // removed scenes; the destructors run after the lock is released
  std::unique_lock lock(mutex_);
  while (!slots_.contains(scene) && !fitsOneMore()) {
    lock.unlock();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // polls, since nothing signals when a scene is released
    lock.lock();
  }
  if (!slots_.contains(scene)) {
    // Unload unused scenes, starting with the least recently used one, until the new scene fits. Unload at least one if
    // memory is scarce.
    for (;;) {
      auto leastRecent = slots_.end();
      for (auto slot = slots_.begin(); slot != slots_.end(); ++slot) {
        if (slot->second.use_count() > 1) continue;
        if (leastRecent == slots_.end() || slot->second->lastUse < leastRecent->second->lastUse) leastRecent = slot;
      }
      const bool scarce = unloaded.empty() && memoryIsScarce();
      const bool fits = plan_.bytesInMemory((slots_.size() + 1) * largest_) <= memoryLimitBytes();
      if (leastRecent == slots_.end() || (!scarce && fits)) break;
      unloaded.push_back(std::move(leastRecent->second));
      slots_.erase(leastRecent);
    }
    slots_[scene] = std::make_shared<Slot>();
  }
  slots_[scene]->lastUse = ++uses_;
  return slots_[scene];
}

void SceneStore::announce(std::size_t sequence) {
  const std::scoped_lock lock(mutex_);
  ++announcedFrames_[sceneOf_[sequence]];
}

void SceneStore::release(std::size_t sequence) {
  // Keeps an unloaded scene alive until the lock is released, since the scene's destructor must run without the lock.
  std::shared_ptr<Slot> unloaded;
  const std::scoped_lock lock(mutex_);
  const auto frames = announcedFrames_.find(sceneOf_[sequence]);
  if (frames == announcedFrames_.end() || --frames->second > 0) return;
  announcedFrames_.erase(frames);
  const auto slot = slots_.find(sceneOf_[sequence]);
  if (slot == slots_.end()) return;
  unloaded = std::move(slot->second);
  slots_.erase(slot);
}

std::shared_ptr<const ReadyScene> SceneStore::enter(std::size_t sequence) {
  const std::shared_ptr<Slot> slot = slotOf(sceneOf_[sequence]);
  tbb::collaborative_call_once(slot->once, [&]() SCANMILL_UNWATCHED { withWaiters([&] { load(sequence, *slot); }); });
  slot->loaded.take();
  if (slot->failure) std::rethrow_exception(slot->failure);
  checkPath(sequence, slot->ready);
  return {slot, &slot->ready};
}

std::uint64_t loadScene(ShotSource& source, std::size_t sequence, ReadyScene& ready) {
  const Plan& plan = source.plan();
  const Sequence& loaded = plan.pipeline.sequences[sequence];
  std::vector<FileRecord> files;
  {
    const FilesRead read;
    ready.scene = source.load(sequence);
    files = recordsOf(read, plan.pipeline.file.parent_path());
  }
  ready.method = source.method(ready.scene);
  const std::optional<ListedObjects>& listed = plan.pipeline.output.objects;
  if (listed) ready.objects = std::make_unique<SceneObjects>(ready.scene, *ready.method, *listed);
  if (plan.pipeline.output.voxels) ready.voxels = std::make_unique<SceneVoxels>(ready.scene);
  const std::uint64_t bytes = ready.method->memoryBytes() +
                              (ready.objects == nullptr ? 0 : ready.objects->memoryBytes()) +
                              (ready.voxels == nullptr ? 0 : ready.voxels->memoryBytes());
  plan.checkMemory(bytes, "the scene of " + loaded.key());
  ready.facts = std::make_shared<const SceneFacts>(
      SceneFacts{modelledOf(plan, loaded, ready.scene, *ready.method), ready.scene.ontology,
                 ready.objects == nullptr ? std::vector<std::uint16_t>() : ready.objects->classes(), std::move(files)});
  return bytes;
}

// Loads the scene of a sequence into its slot, with its method and its warnings. Stores an exception in Slot::failure.
void SceneStore::load(std::size_t sequence, Slot& slot) {
  const TaskOrder::Task task(slot.loaded, slot.loaded);
  const StageTimer timer(clock_, "setup");
  try {
    const Pipeline& pipeline = plan_.pipeline;
    const Sequence& loaded = pipeline.sequences[sequence];
    loading_(loaded);
    ReadyScene& ready = slot.ready;
    returnFreedMemoryIfScarce();
    const std::uint64_t bytes = loadScene(source_, sequence, ready);
    TraceAccount account;
    for (const Shot& shot : source_.frame(sequence, 0).shots) account += ready.method->prepare(shot);
    if (pipeline.recording == nullptr) ready.probe.emplace(ready.scene, ready.method.get(), pipeline.method.entry);
    returnFreedMemoryIfScarce();
    std::vector<std::string> lines;
    for (const auto& warnings :
         {damageWarnings(ready.scene), sizeWarnings(ready.scene), ruleWarnings(ready.scene),
          unlabeledWarnings(ready.scene), seedWarnings(pipeline, loaded, ready.scene), withoutWarnings(ready.scene),
          vehicleWarnings(pipeline, source_.blockedShares()), driveWarnings(pipeline), sensorWarnings(plan_)}) {
      appendNew(warnings, lines);
    }
    const std::scoped_lock lock(mutex_);
    largest_ = std::max(largest_, bytes);
    SceneWarnings& reported = reported_[sceneOf_[sequence]];
    if (std::exchange(reported.loaded, true)) return;  // its warnings are known
    reported.ofScene = std::move(lines);
    reported.account += account;
  } catch (...) {
    slot.failure = std::current_exception();  // rethrown in each thread that needs the scene
  }
}

void SceneStore::checkPath(std::size_t sequence, const ReadyScene& ready) {
  if (!ready.probe) return;
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(reported_[sequence].pathChecked, true)) return;
  }
  const StageTimer timer(clock_, "setup");
  std::vector<std::string> lines = pathWarnings(source_, sequence, *ready.probe);
  const std::scoped_lock lock(mutex_);
  reported_[sequence].ofPath = std::move(lines);
}

void SceneStore::account(std::size_t sequence, const TraceAccount& account) {
  const std::scoped_lock lock(mutex_);
  reported_[sceneOf_[sequence]].account += account;
}

std::vector<std::string> SceneStore::warnings() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> lines;
  for (const SceneWarnings& reported : reported_) {
    for (const auto& warnings : {reported.ofScene, reported.ofPath, reported.account.warningTexts()}) {
      appendNew(warnings, lines);
    }
  }
  return lines;
}

StageSeconds SceneStore::methodSeconds() const {
  const std::scoped_lock lock(mutex_);
  StageSeconds seconds;
  for (const SceneWarnings& reported : reported_) addSeconds(reported.account.seconds, seconds);
  return seconds;
}

}  // namespace scanmill
