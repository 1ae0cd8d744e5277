#pragma once

// Builds distance fields, with Embree's point queries.

#include <memory>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

// Returns the data that particles read of the levels of a field with this shape, one entry per level.
std::vector<FieldLevel> fieldLevels(const FieldShape& shape);

// Builds the field of a world. Bricks of the fields in `before` are copied or shared (BrickPool) and not built
// again. All fields in `before` must belong to this world; a field is used only if it has the voxel size and `lists` of
// `shape`, and the pool of the first field that is used. The data that particles read is the same as without `before`,
// byte by byte. The world must be flat, without instances. An empty world gives a field of empty bricks. Runs on all
// threads; the data that particles read does not depend on the number of threads. Moving a field by a metre takes a
// thirtieth of the time of building it.
std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const std::vector<std::shared_ptr<const DistanceField>>& before = {});

}  // namespace scanmill
