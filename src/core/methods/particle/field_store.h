#pragma once

// Builds the fields of a run, moves them along with the sensors, and caches them.

#include <list>
#include <memory>
#include <mutex>

#include "base/stage_clock.h"
#include "methods/field/march_job.h"
#include "methods/particle/options.h"
#include "methods/world/worlds.h"

namespace scanmill {

class FieldStore {
 public:
  // The store needs memory for at least this many fields: four pools, each as large as 1.5 fields on average, so that
  // fields can move along with sensors. There are more pools, up to about one per thread (each thread works on its own
  // drive), as long as all pools fit into an eighth of the memory.
  static constexpr std::size_t kFewestFields = 6;

  // The scene must outlive the store.
  FieldStore(const Scene& scene, const ParticleOptions& options);

  // Returns the field around a sensor at `sensor` (m, world frame), which reaches `range` (m) unless the options set
  // fewer levels. Safe to call from several threads: fields are built one after the other, each from earlier
  // fields, and threads that wait for a field help to build it. The seconds of building a field, or of moving a
  // field along with the sensor, are added to the stage "field_build" or "field_update" of `clock`.
  SensorField around(const Vec3d& sensor, double range, StageClock& clock) const;

 private:
  struct CachedField {
    std::weak_ptr<const World> world;
    std::shared_ptr<const DistanceField> field;
  };
  struct Construction;  // a field under construction

  std::shared_ptr<const DistanceField> fieldOf(const std::shared_ptr<const World>& world, const FieldShape& shape,
                                               StageClock& clock) const;
  void build(Construction& construction, StageClock& clock) const;
  void cache(const Construction& construction) const;

  ParticleOptions options_;
  Box bounds_;  // bounds of the scene (m, world frame)
  std::size_t mostPools_;
  Worlds worlds_;
  mutable std::mutex mutex_;
  mutable std::list<CachedField> fields_;               // most recently used first
  mutable std::shared_ptr<Construction> construction_;  // the field under construction; null if there is none
};

}  // namespace scanmill
