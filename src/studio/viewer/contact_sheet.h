#pragma once

// The objects of a scene as a contact sheet: a cell for each, so that their classes, sizes and headings are seen at a
// glance.

#include <cstddef>

#include "scene/scene.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::size_t kMostSheetCells = 60;

// The first copy of each object by itself, in the order of the scene and in the colours of its classes, with its name,
// its size along its own x, y and z (those of its first part, of a file that places its parts by itself) and its most
// frequent classes. Beside it stand a block of 1.8 m, as high as a
// person, and an arrow along its x axis. What has no class is magenta. Of more than kMostSheetCells objects the first
// of each series ("house 1", "house 2", ...) are shown, then the second of each, until so many are there. Wants a
// device as openOffscreen() does. Throws Error.
Image drawContactSheet(const Scene& scene);

}  // namespace scanmill
