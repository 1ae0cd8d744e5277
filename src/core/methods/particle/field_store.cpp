#include "methods/particle/field_store.h"

#include <tbb/collaborative_call_once.h>

#include <algorithm>
#include <exception>
#include <set>
#include <utility>
#include <vector>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/tsan_order.h"

namespace scanmill {

namespace {

constexpr double kMemoryFraction = 0.125;  // fraction of the memory limit for all pools; kFewestPools may exceed it
// Smallest limit on the number of pools: for two drives, a field under construction, and a pool being released.
constexpr std::size_t kFewestPools = 4;
constexpr std::size_t kFieldsOfPool = 2;  // largest number of cached fields per pool, for two sensors of a vehicle

bool contains(const Box& outer, const Box& inner) {
  return inner.empty() ||
         (outer.low.x <= inner.low.x && outer.low.y <= inner.low.y && outer.low.z <= inner.low.z &&
          outer.high.x >= inner.high.x && outer.high.y >= inner.high.y && outer.high.z >= inner.high.z);
}

// Returns the largest number of pools that may exist, including the pool of the field under construction: the number of
// threads plus 2, or fewer if these take more than kMemoryFraction of the memory limit, but at least kFewestPools.
std::size_t mostPoolsOf(const ParticleOptions& options) {
  const double fittingPools = kMemoryFraction * static_cast<double>(memoryLimitBytes()) / fieldBytes(options);
  const auto usefulPools = static_cast<double>(threadCount() + 2);
  return std::max(static_cast<std::size_t>(std::min(fittingPools, usefulPools)), kFewestPools);
}

}  // namespace

struct FieldStore::Construction {
  Construction(std::shared_ptr<const World> fieldWorld, const FieldShape& fieldShape)
      : world(std::move(fieldWorld)), shape(fieldShape) {}

  const std::shared_ptr<const World> world;
  const FieldShape shape;
  tbb::collaborative_once_flag once;
  TaskOrder done;
  std::shared_ptr<const DistanceField> field;  // null if building failed: see `failure`
  std::exception_ptr failure;
};

FieldStore::FieldStore(const Scene& scene, const ParticleOptions& options)
    : options_(options),
      bounds_(scene.bounds()),
      mostPools_(mostPoolsOf(options)),
      worlds_(scene, Instancing::Never, {}) {}

SensorField FieldStore::around(const Vec3d& sensor, double range, StageClock& clock) const {
  const std::shared_ptr<const World> world = worlds_.near(sensor);
  Box scene;  // bounds relative to the world's origin
  if (!bounds_.empty()) scene = {bounds_.low - world->origin, bounds_.high - world->origin};
  const FieldShape shape = shapeOf(options_, sensor - world->origin, scene, range);
  const Box box = marchBox(shape);
  return {.world = world, .field = fieldOf(world, shape, clock), .box = box, .coversScene = contains(box, scene)};
}

// Returns the field with this shape, cached or newly built. While another thread builds a field, helps this thread.
std::shared_ptr<const DistanceField> FieldStore::fieldOf(const std::shared_ptr<const World>& world,
                                                         const FieldShape& shape, StageClock& clock) const {
  for (;;) {
    std::shared_ptr<Construction> construction;
    bool isBuilder = false;
    {
      const std::scoped_lock lock(mutex_);
      const auto cached = std::ranges::find_if(fields_, [&](const CachedField& entry) {
        return entry.world.lock() == world && entry.field->shape == shape;
      });
      if (cached != fields_.end()) {
        fields_.splice(fields_.begin(), fields_, cached);  // most recently used first
        return cached->field;
      }
      isBuilder = construction_ == nullptr;
      if (isBuilder) construction_ = std::make_shared<Construction>(world, shape);
      construction = construction_;
    }
    if (isBuilder && hasWaiters()) {
      // This thread is loading the scene, so threads that wait for the scene help to build the field.
      build(*construction, clock);
    } else {
      tbb::collaborative_call_once(construction->once, [&]() SCANMILL_UNWATCHED { build(*construction, clock); });
      construction->done.take();
    }
    if (construction->world != world || !(construction->shape == shape)) {
      continue;  // the field that was just built is a different one, for another thread
    }
    if (construction->failure) std::rethrow_exception(construction->failure);
    return construction->field;
  }
}

// Builds the field from its world's cached fields, the nearest first, and caches it. Stores exceptions in `failure`.
// Resets construction_ at the end, so that a thread can begin to build another field.
void FieldStore::build(Construction& construction, StageClock& clock) const {
  const TaskOrder::Task task(construction.done, construction.done);  // tells only TSan that fieldOf() waits for the end
  try {
    std::vector<std::shared_ptr<const DistanceField>> earlierFields;
    {
      const std::scoped_lock lock(mutex_);
      for (const CachedField& entry : fields_) {
        if (entry.world.lock() == construction.world) earlierFields.push_back(entry.field);
      }
    }
    // Threads work on drives that are far apart, so the nearest field belongs to the same drive.
    std::ranges::stable_sort(
        earlierFields, {}, [&](const auto& field) { return length(field->shape.centre - construction.shape.centre); });
    const WallTimer timer;
    withWaiters([&] { construction.field = buildField(*construction.world, construction.shape, earlierFields); });
    clock.add(earlierFields.empty() ? "field_build" : "field_update", timer.seconds());
    const std::scoped_lock lock(mutex_);
    cache(construction);
  } catch (...) {
    construction.failure = std::current_exception();
  }
  const std::scoped_lock lock(mutex_);
  construction_ = nullptr;
}

// Caches the new field. Drops fields of worlds that no longer exist and, beyond the limits, the least recently used
// fields. The caller must have locked mutex_.
void FieldStore::cache(const Construction& construction) const {
  std::erase_if(fields_, [](const CachedField& entry) { return entry.world.expired(); });
  fields_.push_front({construction.world, construction.field});
  const auto pools = [&] {
    std::set<const BrickPool*> distinct;
    for (const CachedField& entry : fields_) distinct.insert(entry.field->pool.get());
    return distinct.size();
  };
  while (fields_.size() > kFieldsOfPool * mostPools_ || pools() + 1 > mostPools_) fields_.pop_back();
}

}  // namespace scanmill
