#pragma once

// Proxy meshes: fewer triangles in the place of many, as collision meshes have.

#include "scene/scene.h"

namespace scanmill {

// The scene with about `keep` (0 to 1] of each mesh's triangles: edges collapse where that changes the shape least
// (quadric error metric; Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997).
// Surfaces keep their materials, classes and objects; nothing crosses from one surface to another, what is closed stays
// closed where they meet, and none vanishes, even where that takes more triangles. Meshes of up to 32 triangles stay as
// they are. A keep of 1 gives the scene as it is.
Scene simplified(const Scene& scene, double keep);

}  // namespace scanmill
