#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "base/vec.h"
#include "methods/field/distance_field.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "sensors/shot.h"

namespace scanmill {

// The field around a sensor.
struct SensorField {
  std::shared_ptr<const World> world;  // the world of which the field was built
  std::shared_ptr<const DistanceField> field;
  Box box;                   // m, relative to the world's origin: particles march only inside of the box
  bool coversScene = false;  // true if the box contains the complete scene
};

// A shot and the field through which its particles march. On a device the particles have this order: 16 columns of the
// first ring, the same 16 columns of each further ring, then the next 16 columns. If the number of columns is not a
// multiple of 16, the surplus particles of the last group do not march.
struct MarchJob {
  static constexpr std::uint32_t kGroupColumns = 16;  // number of columns in a group
  const Shot& shot;
  const ShotFrame& frame;  // the shot's poses, relative to the world's origin
  const SensorField& sensorField;
  std::uint32_t maxSteps;  // largest number of steps of a particle

  const DistanceField& field() const { return *sensorField.field; }
  const TriangleBlock& triangles() const { return sensorField.world->baked; }
  double pathLength() const { return searchDistance(*shot.beams); }  // m, length of particles' paths
  // Returns the number of particles.
  std::size_t size() const {
    return std::size_t{shot.beams->rings} * ((shot.beams->columns + kGroupColumns - 1) / kGroupColumns) * kGroupColumns;
  }
};

}  // namespace scanmill
