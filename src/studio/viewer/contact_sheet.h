#pragma once

// Draws the objects of a scene as a contact sheet with one cell per object, which shows the object's classes, size and
// heading.

#include <cstddef>

#include "scene/scene.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::size_t kMostSheetCells = 60;

// Draws the first copy of each object in a separate cell, in the order of the scene and in the colours of the object's
// classes. The text below the object states the object's name, its size along its x, y and z axes and its most frequent
// classes. If the object's file places several parts, the axes are those of the first part. A block 1.8 m high (the
// height of a person) and an arrow along the x axis are drawn beside the object. Triangles without a class are magenta.
// If the scene has more than kMostSheetCells objects, the sheet shows the first object of each series ("house 1",
// "house 2", ...), then the second of each series, and so on. Needs a device like openOffscreen(). Throws Error.
Image drawContactSheet(const Scene& scene);

}  // namespace scanmill
