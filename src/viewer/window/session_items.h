#pragma once

// Numbers of the viewer's items on its canvas.

#include <cstddef>

#include "viewer/canvas/canvas.h"

namespace scanmill {

constexpr ItemId kMeshItem = 1;
constexpr ItemId kAxesItem = 2;
constexpr ItemId kRangeRingsItem = 3;
constexpr ItemId kTrackItem = 4;
constexpr ItemId kMeasureItem = 5;
constexpr ItemId cloudItem(std::size_t cloud) {
  return static_cast<ItemId>(100 + cloud);
}

}  // namespace scanmill
