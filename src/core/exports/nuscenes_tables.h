#pragma once

// The tables of nuScenes. The layout is described in nuscenes.cpp.

#include <cstddef>

#include "exports/layout.h"

namespace scanmill {

// Writes all tables, splits.json and the map, and creates the folders that may stay empty. Returns the number of boxes.
std::size_t writeNuScenesTables(const ExportPlan& plan, const ReadObjects& read, const ExportFolder& folder);

}  // namespace scanmill
