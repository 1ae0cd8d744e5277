#pragma once

// The procedural town, a scene that needs no download: another place for every seed. All of it follows from its keys
// and the seed.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"

namespace scanmill {

// Adds a town whose main road passes the origin of its frame along +x, the ground there near z = 0. Traffic keeps to
// the right. `fields` is the town's map in a scene file; finish() is called here. Throws InputError with the place.
void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromTown);

// The right-hand lane of the main road through the built part of the town that such a map and the seed describe:
// places on the road's surface a few metres apart, in the town's frame.
std::vector<Vec3d> townLane(Fields& fields, std::uint64_t seed);

}  // namespace scanmill
