#pragma once

// The procedural town, a scene that needs no download: every seed gives another town. It depends only on its keys and
// the seed.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scene/lanes.h"

namespace scanmill {

// Adds a town whose main road passes the origin of the town's frame along +x, with the ground near z = 0 there. `place`
// is the town's pose in the world. `fields` are the keys of `town:` in a scene file; finish() is called here. The
// supply factors multiply the factors that these keys give. Throws InputError with the place in the file.
void addTown(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const SupplyFactors& supply,
             const Affine& place);

// Returns the routes of the sensor's vehicle through the town of these keys and this seed, in the town's frame: one
// straight through the built part, and one that comes out of a side road and turns into another, as far as there are
// side roads on the vehicle's side of the road.
SceneLanes townLanes(Fields& fields, std::uint64_t seed);

}  // namespace scanmill
