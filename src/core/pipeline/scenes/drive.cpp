#include "pipeline/scenes/drive.h"

#include "pipeline/scenes/random_way.h"
#include "pipeline/scenes/scene_ground.h"

namespace scanmill {

bool needsScene(const Trajectory& trajectory) {
  return trajectory.randomWay() != nullptr || trajectory.ground() != nullptr;
}

Trajectory inScene(const Trajectory& trajectory, const SceneProbe& probe, std::uint64_t seed) {
  Trajectory driven = trajectory;
  if (const RandomWay* random = trajectory.randomWay()) {
    driven = driven.along(findRandomWay(probe, *random, seed, trajectory.name()));
  }
  if (const GroundOptions* ground = trajectory.ground()) {
    driven = driven.onGround(SceneGround(probe, classIds(probe.scene().ontology, ground->classes, ground->where)));
  }
  return driven;
}

}  // namespace scanmill
