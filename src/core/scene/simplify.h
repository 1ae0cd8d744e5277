#pragma once

// Makes proxy meshes, which have few triangles in the place of many, as collision meshes do.

#include "scene/scene.h"

namespace scanmill {

// Returns the scene with about the share `keep` of each mesh's triangles, above 0 and at most 1; 1 gives the scene as
// it is. Edges collapse where that changes the shape least (quadric error metric; Garland, Heckbert, "Surface
// Simplification Using Quadric Error Metrics", SIGGRAPH 1997). Surfaces keep their materials, classes and objects. No
// triangle crosses from one surface to another, a closed mesh stays closed where surfaces meet, and no surface
// vanishes, even where that takes more triangles. Meshes of up to 32 triangles stay as they are.
Scene simplified(const Scene& scene, double keep);

}  // namespace scanmill
