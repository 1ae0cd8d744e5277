#pragma once

// Draws the objects of a scene as a contact sheet: a cell for each, so that their classes, sizes and headings are seen
// at a glance.

#include <cstddef>

#include "scene/scene.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::size_t kMostSheetCells = 60;

// Draws the first copy of each object by itself, in the order of the scene and in the colours of its classes, with its
// name, its size along its own x, y and z (the axes of its first part if its file places the parts itself) and its most
// frequent classes. A block of 1.8 m, the height of a person, and an arrow along the object's x axis are drawn beside
// it. Triangles without a class are magenta. If the scene has more than kMostSheetCells objects, the cells are filled
// with the first object of each series ("house 1", "house 2", ...), then with the second of each, and so on. Needs a
// device as openOffscreen() does. Throws Error.
Image drawContactSheet(const Scene& scene);

}  // namespace scanmill
