#pragma once

// The fields of a run: built, or moved along with the sensor.

#include <list>
#include <memory>
#include <mutex>

#include "base/stage_clock.h"
#include "methods/field/build.h"
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

  // How many fields there is to be memory for. There may be more: one for each thread, which works on a drive of its
  // own, and two, as far as an eighth of the memory holds them.
  std::size_t fewestFields() const;

 private:
  struct Known {
    std::shared_ptr<const World> world;
    std::shared_ptr<const DistanceField> field;
  };

  struct Work;  // a field that is being built

  std::shared_ptr<const DistanceField> fieldOf(const std::shared_ptr<const World>& world, const FieldShape& shape,
                                               StageClock& clock) const;
  std::shared_ptr<const DistanceField> known(const std::shared_ptr<const World>& world, const FieldShape& shape) const;
  void build(Work& work, StageClock& clock) const;
  void forget() const;

  ParticleOptions options_;
  Box bounds_;  // m, world
  std::size_t mostFields_;
  Worlds worlds_;
  mutable std::mutex mutex_;
  mutable std::list<Known> fields_;  // the last one first
  mutable std::shared_ptr<Work> work_;
};

}  // namespace scanmill
