#pragma once

// Simplifies meshes to proxies with few triangles, such as collision meshes.

#include "scene/scene.h"

namespace scanmill {

// Returns the scene with about the fraction `keep` of each mesh's triangles. `keep` is above 0 and at most 1; 1 gives
// an unchanged scene. Edges are collapsed first where the shape changes least (quadric error metric; Garland, Heckbert,
// "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997). Surfaces keep their materials, classes and
// objects. No triangle crosses from one surface to another, a closed mesh stays closed between surfaces, and no surface
// vanishes, even if that needs more triangles. Meshes of up to 32 triangles stay unchanged.
[[nodiscard]] Scene simplified(const Scene& scene, double keep);

}  // namespace scanmill
