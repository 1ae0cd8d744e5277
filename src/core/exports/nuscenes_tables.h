#pragma once

// The tables of nuScenes. The layout is described in nuscenes.cpp.

#include "exports/layout.h"

namespace scanmill {

// Writes all tables, splits.json and the map, and creates the folders that may stay empty.
void writeNuScenesTables(const ExportPlan& plan, const ReadObjects& read, const ExportFolder& folder);

}  // namespace scanmill
