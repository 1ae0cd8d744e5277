#include "methods/particle/field_store.h"

#include <algorithm>

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
    : options_(checked(scene, options)), bounds_(scene.bounds()), worlds_(scene, Instancing::Never, {}) {}

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
  const WallTimer timer;
  const DistanceField* moved = before == fields_.end() ? nullptr : before->field.get();
  std::shared_ptr<const DistanceField> made = buildField(*world, shape, moved);
  clock.add(moved == nullptr ? "field_build" : "field_update", timer.seconds());
  if (fields_.size() >= kFieldsInMemory) fields_.pop_back();
  fields_.push_front({world, std::move(made)});
  return fields_.front().field;
}

}  // namespace scanmill
