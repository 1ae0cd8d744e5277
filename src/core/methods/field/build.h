#pragma once

// Builds distance fields, by Embree's point queries.

#include <memory>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

// Returns what particles read of the levels of a field with this shape.
std::vector<FieldLevel> fieldLevels(const FieldShape& shape);

// Builds the field of a world. Where `before` are fields of the same world with the same voxel size and lists, the
// bricks that one of them has are taken over from it, or shared with it (brick_pool.h): all from those of the first
// one's pool. What particles read is the same as without them, byte by byte. The world must be flat: nothing in it is
// instanced. An empty world gives a field of empty bricks. Runs on all threads; what particles read does not depend on
// how many there are. Moving a field by a metre takes a thirtieth of building it.
std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const std::vector<std::shared_ptr<const DistanceField>>& before = {});

}  // namespace scanmill
