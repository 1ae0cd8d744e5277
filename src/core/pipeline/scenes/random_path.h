#pragma once

// Finds random paths that a vehicle can drive on the surfaces of a scene.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "pipeline/scenes/scene_probe.h"
#include "sensors/trajectory.h"

namespace scanmill {

// Returns the points of a random path on surfaces of the classes in `random` (world frame, m). The points are about 4 m
// apart, and the path has the length that `random` asks for, rounded up to arcs of 4 m. The path has room for a vehicle
// 2 m wide and 2.5 m high, and its bends mostly have a radius of more than 5 m. It depends on the seed and the drive's
// name. On roads it is 2 m from the edge on the side that `random` names, or in the middle if the road is narrower than
// 4 m. In open places it goes left, right or straight on at random, and prefers places that it has not passed yet.
// Throws InputError if the scene has no such surface or no path of this length.
std::vector<Vec3d> findRandomPath(const SceneProbe& probe, const RandomPath& random, std::uint64_t seed,
                                  const std::string& name);

}  // namespace scanmill
