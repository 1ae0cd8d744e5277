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
  // threads: one waits while another builds. The seconds of building a field, or of moving one along with the sensor,
  // are added to the stage "field_build" or "field_update" of `clock`.
  Place around(const Vec3d& sensor, double range, StageClock& clock) const;

 private:
  struct Known {
    std::shared_ptr<const World> world;
    std::shared_ptr<const DistanceField> field;
  };

  std::shared_ptr<const DistanceField> fieldOf(const std::shared_ptr<const World>& world, const FieldShape& shape,
                                               StageClock& clock) const;

  ParticleOptions options_;
  Box bounds_;  // m, world
  Worlds worlds_;
  mutable std::mutex mutex_;
  mutable std::list<Known> fields_;  // the last one first
};

}  // namespace scanmill
