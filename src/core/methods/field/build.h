#pragma once

// Builds distance fields, by Embree's point queries.

#include <memory>

#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

// Builds the field of a world. Where `before` is a field of the same world with the same voxel size and lists, the
// bricks that both have are copied from it; what particles read is the same, byte by byte, as without it (null). The
// world must be flat: nothing in it is instanced. An empty world gives a field of empty bricks. Runs on all threads;
// the bytes do not depend on how many there are. Moving a field by a metre takes a twentieth of building it, or less.
std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const DistanceField* before);

}  // namespace scanmill
