#pragma once

// YAML keys of objects whose file is a point cloud or a height raster.

#include "assets/asset.h"
#include "config/value.h"

namespace scanmill {

// Read the options `points` and `heights` of an object (docs/keys.md). Throw InputError.
PointOptions readPointOptions(const Value& value);
HeightOptions readHeightOptions(const Value& value);

// Returns a key for comparison: two keys are equal only if all options are equal.
std::string keyOf(const PointOptions& points, const HeightOptions& heights);

}  // namespace scanmill
