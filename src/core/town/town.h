#pragma once

// The procedural town, a scene that needs no download: another place for every seed. All of it follows from its keys
// and the seed.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scene/lanes.h"

namespace scanmill {

// Adds a town whose main road passes the origin of its frame along +x, the ground there near z = 0. `fields` is the
// town's map in a scene file; finish() is called here. Throws InputError with the place. The factors come on top of the
// map's own.
void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const SupplyFactors& supply,
             const Affine& place);

// The ways through the town that such a map and the seed describe, in the town's frame: through its built part, or as
// far as the side roads on its drivers' side let one come out of one and turn into another.
SceneLanes townLanes(Fields& fields, std::uint64_t seed);

}  // namespace scanmill
