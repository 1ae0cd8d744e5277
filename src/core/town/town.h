#pragma once

// The procedural town, a scene that needs no download. It depends only on its keys and the seed.

#include <cstdint>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"

namespace scanmill {

// Adds a town. In its frame the main road passes the origin along +x, where the ground is near z = 0; `place` is its
// pose in the world. `fields`: the keys of `town:`, whose finish() is called here. Call builder.drawReflectances()
// first: the materials have the builder's reflectances. Throws InputError with the place in the file.
void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& place);

// Returns two routes of the ego vehicle in the town's frame: along the main road; and from a side road at the right
// into the main road and from there into another side road at the right, as far as the town has these side roads.
SceneLanes townLanes(Fields& fields, std::uint64_t seed);

}  // namespace scanmill
