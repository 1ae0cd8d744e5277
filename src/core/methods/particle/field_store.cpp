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
#include "methods/field/build.h"

namespace scanmill {

namespace {

constexpr double kMemoryFraction = 0.125;  // fraction of memoryLimitBytes() that more than kFewestPools pools may take
// Least limit on the number of pools of fields around sensors: two for two drives, one under construction, one being
// released.
constexpr std::size_t kFewestPools = 4;
constexpr std::size_t kFieldsOfPool = 2;  // largest number of cached fields per pool, for two sensors of a vehicle

bool holds(const Box& outer, const Box& inner) {
  return inner.empty() ||
         (outer.low.x <= inner.low.x && outer.low.y <= inner.low.y && outer.low.z <= inner.low.z &&
          outer.high.x >= inner.high.x && outer.high.y >= inner.high.y && outer.high.z >= inner.high.z);
}

// Returns `options`. Throws InputError if they are wrong. Called before anything is built, so that planning finds the
// error.
const ParticleOptions& checked(const ParticleOptions& options) {
  checkField(options, static_cast<double>(memoryLimitBytes()));
  return options;
}

// Returns the largest number of pools that may exist, including the pool of the field under construction.
std::size_t mostPoolsOf(const ParticleOptions& options) {
  const double fit = kMemoryFraction * static_cast<double>(memoryLimitBytes()) / fieldBytes(options);
  const auto wanted = static_cast<double>(threadCount() + 2);
  return std::max(static_cast<std::size_t>(std::min(fit, wanted)), kFewestPools);
}

// Returns the squared distance between the centres of two fields (m^2).
double apart2(const FieldShape& a, const FieldShape& b) {
  const Vec3d gap = a.centre - b.centre;
  return dot(gap, gap);
}

}  // namespace

struct FieldStore::Construction {
  Construction(std::shared_ptr<const World> of, const FieldShape& asked) : world(std::move(of)), shape(asked) {}

  const std::shared_ptr<const World> world;
  const FieldShape shape;
  tbb::collaborative_once_flag once;
  TaskOrder done;
  std::shared_ptr<const DistanceField> field;  // null if building failed: see `failure`
  std::exception_ptr failure;
};

FieldStore::FieldStore(const Scene& scene, const ParticleOptions& options)
    : options_(checked(options)),
      bounds_(scene.bounds()),
      mostPools_(mostPoolsOf(options)),
      worlds_(scene, Instancing::Never, {}) {}

SensorField FieldStore::around(const Vec3d& sensor, double range, StageClock& clock) const {
  SensorField result;
  result.world = worlds_.near(sensor);
  const Vec3d& origin = result.world->origin;
  Box scene;
  if (!bounds_.empty()) scene = {bounds_.low - origin, bounds_.high - origin};
  const FieldShape shape = shapeOf(options_, sensor - origin, scene, range);
  result.box = marchBox(shape);
  result.coversScene = holds(result.box, scene);
  result.field = fieldOf(result.world, shape, clock);
  return result;
}

std::shared_ptr<const DistanceField> FieldStore::fieldOf(const std::shared_ptr<const World>& world,
                                                         const FieldShape& shape, StageClock& clock) const {
  for (;;) {
    std::shared_ptr<Construction> construction;
    bool isBuilder = false;
    {
      const std::scoped_lock lock(mutex_);
      if (auto field = cachedField(world, shape)) return field;
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
    if (construction->world != world || !(construction->shape == shape))
      continue;  // another thread needed a different field first
    if (construction->failure) std::rethrow_exception(construction->failure);
    return construction->field;
  }
}

// Returns the field if it is cached, otherwise null. The caller must have locked mutex_.
std::shared_ptr<const DistanceField> FieldStore::cachedField(const std::shared_ptr<const World>& world,
                                                             const FieldShape& shape) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [&](const CachedField& entry) {
    return entry.world.lock() == world && entry.field->shape == shape;
  });
  if (found == fields_.end()) return nullptr;
  fields_.splice(fields_.begin(), fields_, found);
  return fields_.front().field;
}

void FieldStore::build(Construction& construction, StageClock& clock) const {
  const TaskOrder::Task task(construction.done, construction.done);
  try {
    std::vector<std::shared_ptr<const DistanceField>> before;
    {
      const std::scoped_lock lock(mutex_);
      for (const CachedField& entry : fields_) {
        if (entry.world.lock() == construction.world) before.push_back(entry.field);
      }
    }
    // Threads work on drives that are far apart, so the nearest field belongs to the same drive.
    std::ranges::stable_sort(before, {}, [&](const auto& field) { return apart2(field->shape, construction.shape); });
    const WallTimer timer;
    withWaiters([&] { construction.field = buildField(*construction.world, construction.shape, before); });
    clock.add(before.empty() ? "field_build" : "field_update", timer.seconds());
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
    std::set<const BrickPool*> all;
    for (const CachedField& entry : fields_) all.insert(entry.field->pool.get());
    return all.size();
  };
  while (fields_.size() > kFieldsOfPool * mostPools_ || pools() + 1 > mostPools_) fields_.pop_back();
}

}  // namespace scanmill
