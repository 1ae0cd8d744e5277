#include "pipeline/run/scene_store.h"

#include <tbb/collaborative_call_once.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "base/append_new.h"
#include "base/memory.h"
#include "base/tsan_order.h"
#include "pipeline/plan/scene_shares.h"
#include "pipeline/plan/warnings.h"
#include "pipeline/plan/way_warnings.h"

namespace scanmill {

namespace {

bool memoryIsScarce() {
  return 2 * residentBytes() > memoryLimitBytes();
}

}  // namespace

struct SceneStore::Slot {
  tbb::collaborative_once_flag once;
  TaskOrder loaded;  // what the thread that loads does comes before what others do with it
  std::exception_ptr failure;
  ReadyScene ready;
  std::uint64_t lastUse = 0;
};

SceneStore::SceneStore(const Plan& plan, std::function<void(const Sequence&)> loading)
    : plan_(plan), loading_(std::move(loading)), told_(plan.pipeline().sequences.size()), clock_({"setup"}) {
  const std::vector<Sequence>& all = plan.pipeline().sequences;
  for (const Sequence& sequence : all) {
    const auto first =
        std::find_if(all.begin(), all.end(), [&](const auto& other) { return other.sameScene(sequence); });
    sceneOf_.push_back(static_cast<std::size_t>(first - all.begin()));
  }
}

SceneStore::~SceneStore() = default;

std::shared_ptr<SceneStore::Slot> SceneStore::slotOf(std::size_t scene) {
  std::shared_ptr<Slot> gone;  // destroyed without the lock
  const std::scoped_lock lock(mutex_);
  if (!slots_.contains(scene)) {
    // Where memory is scarce, one goes for each that comes: of those that nobody uses the one that was not used for the
    // longest time.
    auto oldest = slots_.end();
    for (auto slot = slots_.begin(); slot != slots_.end(); ++slot) {
      if (slot->second.use_count() > 1) continue;
      if (oldest == slots_.end() || slot->second->lastUse < oldest->second->lastUse) oldest = slot;
    }
    if (oldest != slots_.end() && memoryIsScarce()) {
      gone = std::move(oldest->second);
      slots_.erase(oldest);
    }
    slots_[scene] = std::make_shared<Slot>();
  }
  slots_[scene]->lastUse = ++uses_;
  return slots_[scene];
}

void SceneStore::expect(std::size_t sequence) {
  const std::scoped_lock lock(mutex_);
  ++expected_[sceneOf_[sequence]];
}

void SceneStore::leave(std::size_t sequence) {
  std::shared_ptr<Slot> last;  // destroyed without the lock
  const std::scoped_lock lock(mutex_);
  const auto expected = expected_.find(sceneOf_[sequence]);
  if (expected == expected_.end() || --expected->second > 0) return;
  expected_.erase(expected);
  const auto slot = slots_.find(sceneOf_[sequence]);
  if (slot == slots_.end()) return;
  last = std::move(slot->second);
  slots_.erase(slot);
}

std::shared_ptr<const ReadyScene> SceneStore::enter(std::size_t sequence) {
  const std::shared_ptr<Slot> slot = slotOf(sceneOf_[sequence]);
  tbb::collaborative_call_once(slot->once, [&]() SCANMILL_UNWATCHED { load(sequence, *slot); });
  slot->loaded.take();
  if (slot->failure) std::rethrow_exception(slot->failure);
  lookAtWay(sequence, slot->ready);
  return {slot, &slot->ready};
}

void SceneStore::load(std::size_t sequence, Slot& slot) {
  const TaskOrder::Task task(slot.loaded, slot.loaded);
  const StageTimer timer(clock_, "setup");
  try {
    const Pipeline& pipeline = plan_.pipeline();
    const Sequence& own = pipeline.sequences[sequence];
    loading_(own);
    ReadyScene& ready = slot.ready;
    ready.scene = plan_.loadScene(own);
    ready.method = plan_.makeMethod(ready.scene);
    plan_.checkMemory(*ready.method, "the scene of " + own.key());
    ready.modelled = ready.method->modelled();
    TraceAccount account;
    for (const Shot& shot : plan_.shots(sequence, 0)) account += ready.method->prepare(shot);
    if (pipeline.recording == nullptr) ready.probe.emplace(ready.scene, ready.method.get(), pipeline.method.entry);
    std::vector<std::string> lines;
    for (const auto& more :
         {damageWarnings(ready.scene), sizeWarnings(ready.scene), thingSizeWarnings(ready.scene),
          ruleWarnings(ready.scene), unlabeledWarnings(ready.scene), seedWarnings(pipeline, own, ready.scene),
          shareWarnings(ready.scene), vehicleWarnings(plan_), driveWarnings(pipeline)}) {
      appendNew(more, lines);
    }
    const std::scoped_lock lock(mutex_);
    Told& told = told_[sceneOf_[sequence]];
    if (std::exchange(told.loaded, true)) return;  // it was here before
    told.ofScene = std::move(lines);
    told.account += account;
  } catch (...) {
    slot.failure = std::current_exception();  // that all see who need the scene
  }
}

void SceneStore::lookAtWay(std::size_t sequence, const ReadyScene& ready) {
  if (!ready.probe) return;
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(told_[sequence].looked, true)) return;
  }
  const StageTimer timer(clock_, "setup");
  std::vector<std::string> lines = wayWarnings(plan_, sequence, *ready.probe);
  const std::scoped_lock lock(mutex_);
  told_[sequence].ofWay = std::move(lines);
}

void SceneStore::account(std::size_t sequence, const TraceAccount& account) {
  const std::scoped_lock lock(mutex_);
  told_[sceneOf_[sequence]].account += account;
}

std::vector<std::string> SceneStore::warnings() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> lines;
  for (const Told& told : told_) {
    for (const auto& more : {told.ofScene, told.ofWay, told.account.warningTexts()}) appendNew(more, lines);
  }
  return lines;
}

StageSeconds SceneStore::methodSeconds() const {
  const std::scoped_lock lock(mutex_);
  StageSeconds seconds;
  for (const Told& told : told_) addSeconds(told.account.seconds, seconds);
  return seconds;
}

double SceneStore::setupSeconds() const {
  return clock_.seconds().at("setup");
}

}  // namespace scanmill
