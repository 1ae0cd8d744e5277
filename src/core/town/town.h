#pragma once

// The procedural town, a scene that needs no download. It depends only on its keys and the seed; every seed gives
// another town.

#include <cstdint>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"

namespace scanmill {

// Adds a town. In the town's frame the main road passes the origin along +x, where the ground is near z = 0. `place` is
// the town's pose in the world. `fields` are the keys of `town:` in a scene file; finish() is called here. The
// reflectances of its materials are those of `builder`: call drawReflectances() first. Throws InputError with the place
// in the file.
void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& place);

// Returns two routes of the ego vehicle through a town with these keys and this seed, in the town's frame: one
// straight through the built-up part, and one from a side road to the main road and into another side road, if there
// are side roads at the right of the main road.
SceneLanes townLanes(Fields& fields, std::uint64_t seed);

}  // namespace scanmill
