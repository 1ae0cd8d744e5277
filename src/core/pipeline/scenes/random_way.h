#pragma once

// Ways that vehicles may take over the surfaces of a scene.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "pipeline/scenes/scene_probe.h"
#include "sensors/trajectory.h"

namespace scanmill {

// Places some metres apart (m, world), on surfaces of the classes of `random`, with room for a vehicle of 2 m x 2.5 m,
// hardly a bend tighter than 5 m, about as long as `random` asks (in arcs of 4 m). Which way it takes follows from the
// seed and the drive's name. On roads it keeps to its side, 2 m from their edge or in the middle of what is narrower
// than 4 m; where they open, it goes left, right or straight on at random; it prefers where it has not been. Throws
// InputError where the scene has no such surface, or none that is long enough.
std::vector<Vec3d> findRandomWay(const SceneProbe& probe, const RandomWay& random, std::uint64_t seed,
                                 const std::string& name);

}  // namespace scanmill
