#pragma once

// The fields of a run: built, or moved along with the sensor.

#include <list>
#include <memory>
#include <mutex>

#include "base/stage_clock.h"
#include "methods/field/distance_field.h"
#include "methods/particle/shape.h"
#include "methods/world/worlds.h"

namespace scanmill {

class FieldStore {
 public:
  // The scene must outlive it. Throws InputError where the field would be too large for this machine: see checkField()
  // in shape.h.
  FieldStore(const Scene& scene, const ParticleOptions& options);

  struct Place {
    std::shared_ptr<const World> world;
    std::shared_ptr<const DistanceField> field;
    Box box;     // m, relative to the world's origin: where particles may march
    bool whole;  // nothing of the scene lies outside of the box
  };
  // Around a sensor (m), reaching `range` (m) far where the options do not say otherwise. Safe to call from several
  // threads: fields are built one after the other, each out of those before, and whoever waits for one helps with it.
  // The seconds of building a field, or of moving one along with the sensor, are added to the stage "field_build" or
  // "field_update" of `clock`.
  Place around(const Vec3d& sensor, double range, StageClock& clock) const;

  // So many fields are in memory at least where the sensors drive, with the room that moving needs. There are more, one
  // for each thread, which works on a drive of its own, as far as an eighth of the memory holds them.
  std::size_t fewestFields() const;

 private:
  struct Known {
    std::weak_ptr<const World> world;
    std::shared_ptr<const DistanceField> field;
  };
  struct Work;  // a field that is being built

  std::shared_ptr<const DistanceField> fieldOf(const std::shared_ptr<const World>& world, const FieldShape& shape,
                                               StageClock& clock) const;
  std::shared_ptr<const DistanceField> known(const std::shared_ptr<const World>& world, const FieldShape& shape) const;
  void build(Work& work, StageClock& clock) const;
  void keep(const Work& work) const;

  ParticleOptions options_;
  Box bounds_;  // m, world
  std::size_t mostPools_;
  Worlds worlds_;
  mutable std::mutex mutex_;
  mutable std::list<Known> fields_;     // the last used one first
  mutable std::shared_ptr<Work> work_;  // one at a time: the next one is built out of it
};

}  // namespace scanmill
