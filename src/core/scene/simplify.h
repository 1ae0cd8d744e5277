#pragma once

// Simplifies meshes to proxies with few triangles, such as collision meshes.

#include "scene/scene.h"

namespace scanmill {

// Returns the scene with about the share `keep` of each mesh's triangles. `keep` is above 0 and at most 1; 1 gives an
// unchanged scene. Edges collapse where that changes the shape least (quadric error metric; Garland, Heckbert, "Surface
// Simplification Using Quadric Error Metrics", SIGGRAPH 1997). Surfaces keep their materials, classes and objects. No
// triangle crosses from one surface to another, a closed mesh stays closed where surfaces meet, and no surface
// vanishes, even if more triangles are needed for that. Meshes of up to 32 triangles stay as they are.
Scene simplified(const Scene& scene, double keep);

}  // namespace scanmill
