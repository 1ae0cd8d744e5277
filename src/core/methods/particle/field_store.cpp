#include "methods/particle/field_store.h"

#include <tbb/collaborative_call_once.h>

#include <algorithm>
#include <set>
#include <vector>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/tsan_order.h"

namespace scanmill {

namespace {

constexpr double kShareOfMemory = 0.125;    // that fields may take
constexpr std::size_t kFewestFields = 4;    // two drives, one that is built, one that is given up
constexpr std::size_t kFieldsOfThread = 2;  // that share their bricks: of two sensors of a vehicle

bool holds(const Box& outer, const Box& inner) {
  return inner.empty() ||
         (outer.low.x <= inner.low.x && outer.low.y <= inner.low.y && outer.low.z <= inner.low.z &&
          outer.high.x >= inner.high.x && outer.high.y >= inner.high.y && outer.high.z >= inner.high.z);
}

// Before anything is built, so that a plan refuses what a run would.
const ParticleOptions& checked(const Scene& scene, const ParticleOptions& options) {
  checkField(options, scene.bounds(), static_cast<double>(memoryLimitBytes()));
  return options;
}

std::size_t mostFieldsOf(const ParticleOptions& options, const Box& scene) {
  if (options.extent == ParticleOptions::Extent::Scene) return 1;
  const double fit = kShareOfMemory * static_cast<double>(memoryLimitBytes()) / fieldBytes(options, scene);
  const auto wanted = static_cast<double>(threadCount() + 2);
  return std::max(static_cast<std::size_t>(std::min(fit, wanted)), kFewestFields);
}

// How far apart the centres of two fields are, squared (m^2).
double apart2(const FieldShape& a, const FieldShape& b) {
  const Vec3d way = a.centre - b.centre;
  return dot(way, way);
}

}  // namespace

struct FieldStore::Work {
  std::shared_ptr<const World> world;
  FieldShape shape;
  tbb::collaborative_once_flag once;
  TaskOrder done;
  std::shared_ptr<const DistanceField> field;
};

FieldStore::FieldStore(const Scene& scene, const ParticleOptions& options)
    : options_(checked(scene, options)),
      bounds_(scene.bounds()),
      mostFields_(mostFieldsOf(options, bounds_)),
      worlds_(scene, Instancing::Never, {}) {}

std::size_t FieldStore::fewestFields() const {
  return options_.extent == ParticleOptions::Extent::Scene ? 1 : kFewestFields;
}

FieldStore::Place FieldStore::around(const Vec3d& sensor, double range, StageClock& clock) const {
  Place place;
  place.world = worlds_.near(sensor);
  const Vec3d& origin = place.world->origin;
  Box scene;
  if (!bounds_.empty()) scene = {bounds_.low - origin, bounds_.high - origin};
  const FieldShape shape = shapeOf(options_, sensor - origin, scene, range);
  place.box = marchBox(shape);
  place.whole = holds(place.box, scene);
  place.field = fieldOf(place.world, shape, clock);
  return place;
}

std::shared_ptr<const DistanceField> FieldStore::fieldOf(const std::shared_ptr<const World>& world,
                                                         const FieldShape& shape, StageClock& clock) const {
  for (;;) {
    std::shared_ptr<Work> work;
    bool own = false;
    {
      const std::scoped_lock lock(mutex_);
      if (auto field = known(world, shape)) return field;
      own = work_ == nullptr;
      if (own) {
        work_ = std::make_shared<Work>();
        work_->world = world;
        work_->shape = shape;
      }
      work = work_;
    }
    tbb::collaborative_call_once(work->once, [&]() SCANMILL_UNWATCHED { build(*work, clock); });
    work->done.take();
    if (own) return work->field;
  }
}

// Called with mutex_ locked. Null: it is not there.
std::shared_ptr<const DistanceField> FieldStore::known(const std::shared_ptr<const World>& world,
                                                       const FieldShape& shape) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [&](const Known& known) {
    return known.world == world && known.field->shape == shape;
  });
  if (found == fields_.end()) return nullptr;
  fields_.splice(fields_.begin(), fields_, found);
  return fields_.front().field;
}

void FieldStore::build(Work& work, StageClock& clock) const {
  const TaskOrder::Task task(work.done, work.done);
  std::vector<std::shared_ptr<const DistanceField>> before;
  {
    const std::scoped_lock lock(mutex_);
    for (const Known& known : fields_) {
      if (known.world == work.world) before.push_back(known.field);
    }
  }
  // Threads work on drives that are far from each other: the nearest field is of the same one.
  std::ranges::stable_sort(before, {}, [&](const auto& field) { return apart2(field->shape, work.shape); });
  const auto end = [&] {
    if (work_.get() == &work) work_ = nullptr;
  };
  try {
    const WallTimer timer;
    work.field = buildField(*work.world, work.shape, before);
    clock.add(before.empty() ? "field_build" : "field_update", timer.seconds());
  } catch (...) {
    const std::scoped_lock lock(mutex_);
    end();
    throw;
  }
  const std::scoped_lock lock(mutex_);
  end();
  fields_.push_front({work.world, work.field});
  forget();
}

// Called with mutex_ locked: lets go of those that were not used for the longest time.
void FieldStore::forget() const {
  const auto pools = [&] {
    std::set<const BrickPool*> all;
    for (const Known& known : fields_) all.insert(known.field->pool.get());
    return all.size();
  };
  while (fields_.size() > 1 && (fields_.size() > kFieldsOfThread * mostFields_ || pools() + 1 > mostFields_)) {
    fields_.pop_back();
  }
}

}  // namespace scanmill
