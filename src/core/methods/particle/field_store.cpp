#include "methods/particle/field_store.h"

#include <algorithm>
#include <string>

#include "base/memory.h"

namespace scanmill {

namespace {

constexpr std::size_t kFieldsInMemory = 3;  // of shots that are in flight at once

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

}  // namespace

FieldStore::FieldStore(const Scene& scene, const ParticleOptions& options)
    : options_(checked(scene, options)),
      bounds_(scene.bounds()),
      worlds_(scene, Instancing::Never, {}),
      cache_(options.cache, options.cache.empty() ? std::string() : geometryHash(scene)) {}

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
  const std::scoped_lock lock(mutex_);
  for (auto it = fields_.begin(); it != fields_.end(); ++it) {
    if (it->world != world || !(it->field->shape == shape)) continue;
    fields_.splice(fields_.begin(), fields_, it);
    return fields_.front().field;
  }
  const auto before =
      std::find_if(fields_.begin(), fields_.end(), [&](const Known& known) { return known.world == world; });
  std::shared_ptr<const DistanceField> made =
      make(*world, shape, before == fields_.end() ? nullptr : before->field.get(), clock);
  if (fields_.size() >= kFieldsInMemory) fields_.pop_back();
  fields_.push_front({world, std::move(made)});
  return fields_.front().field;
}

// The caller holds mutex_.
std::shared_ptr<const DistanceField> FieldStore::make(const World& world, const FieldShape& shape,
                                                      const DistanceField* before, StageClock& clock) const {
  const WallTimer timer;
  if (before != nullptr) {
    std::shared_ptr<const DistanceField> moved = buildField(world, shape, before);
    clock.add("field_update", timer.seconds());
    return moved;
  }
  if (std::shared_ptr<const DistanceField> found = cache_.find(shape, world.origin)) {
    clock.add("field_load", timer.seconds());
    return found;
  }
  std::shared_ptr<const DistanceField> built = buildField(world, shape, nullptr);
  clock.add("field_build", timer.seconds());
  cache_.store(*built, world.origin);
  return built;
}

}  // namespace scanmill
