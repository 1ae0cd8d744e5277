#pragma once

// What facet.h does, in GLSL, with its bits: sums and products are `precise`, quotients and roots are corrected until
// they are rounded as IEEE 754 rounds them. Triangles are given by their corners (voxels, from a brick's centre).

#include <string>

namespace scanmill {

//     float distance2To(dvec3 a, dvec3 b, dvec3 c, vec3 point, inout bool sure)
//
// is what Facet::distance2() gives; `sure` becomes false where a number is so small that a device may take it for
// nothing.
//
//     float rootOf(float x)
//     double rootOf(double x, double about)
//     double inverseOf(double x, double about)
//
// are square roots and 1 / x, of what is not too small; `about` is off by a few units in the last place.
std::string facetShader();

//     bool meetsCube(dvec3 a, dvec3 b, dvec3 c, vec3 point)
//
// tells whether the triangle meets the cube that reaches kListedHalf around a point: whether CubeTest::excess() is at
// most 0.
std::string cubeShader();

}  // namespace scanmill
