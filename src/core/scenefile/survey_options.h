#pragma once

// YAML keys of objects whose file is a point cloud or a height raster.

#include "assets/asset.h"
#include "config/value.h"

namespace scanmill {

// Read the options `points` and `heights` of an object (docs/keys.md). Throw InputError.
PointOptions readPointOptions(const Value& value);
HeightOptions readHeightOptions(const Value& value);

}  // namespace scanmill
