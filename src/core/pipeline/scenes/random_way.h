#pragma once

// Finds random paths that a vehicle can drive on the surfaces of a scene.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "pipeline/scenes/scene_probe.h"
#include "sensors/trajectory.h"

namespace scanmill {

// Returns the points of a path, some metres apart (m, world), on surfaces of the classes of `random`, about as long as
// `random` asks (in arcs of 4 m). The path has room for a vehicle 2 m wide and 2.5 m high, and hardly a bend of less
// than 5 m radius. It follows from the seed and the drive's name. On roads it keeps to its side, 2 m from the edge, or
// in the middle if the road is narrower than 4 m. In open places it goes left, right or straight on at random, and it
// prefers places where it has not been. Throws InputError if the scene has no such surface, or no path long enough.
std::vector<Vec3d> findRandomWay(const SceneProbe& probe, const RandomWay& random, std::uint64_t seed,
                                 const std::string& name);

}  // namespace scanmill
