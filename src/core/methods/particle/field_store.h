#pragma once

// The fields of a run: built, taken from disk, or moved along with the sensor.

#include <list>
#include <memory>
#include <mutex>

#include "methods/field/build.h"
#include "methods/field/cache.h"
#include "methods/field/field.h"
#include "methods/particle/shape.h"
#include "methods/world/worlds.h"

namespace scanmill {

class FieldStore {
 public:
  // The scene must outlive it. Throws InputError where the field would be too large for this machine; see
  // checkField().
  FieldStore(const Scene& scene, const ParticleOptions& options);

  struct Place {
    std::shared_ptr<const World> world;
    std::shared_ptr<const Field> field;
    Box box;     // m, relative to the world's origin: where particles may fly
    bool whole;  // nothing of the scene lies outside of the box
  };
  // Around a sensor (m), reaching `range` (m) far where the options do not say otherwise. Safe to call from several
  // threads: one waits while another builds.
  Place around(const Vec3d& sensor, double range) const;

  // s of wall-clock time so far, and how often.
  struct Seconds {
    double build = 0, update = 0, load = 0;
    std::uint64_t builds = 0, updates = 0, loads = 0;
  };
  Seconds seconds() const;

 private:
  struct Known {
    std::shared_ptr<const World> world;
    std::shared_ptr<const Field> field;
  };

  std::shared_ptr<const Field> fieldOf(const std::shared_ptr<const World>& world, const FieldShape& shape) const;
  std::shared_ptr<const Field> make(const World& world, const FieldShape& shape, const Field* before) const;

  ParticleOptions options_;
  Box bounds_;  // m, world
  Worlds worlds_;
  FieldCache cache_;
  mutable std::mutex mutex_;
  mutable std::list<Known> fields_;  // the last one first
  mutable Seconds seconds_;
};

}  // namespace scanmill
