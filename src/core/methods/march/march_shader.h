#pragma once

#include <string>

namespace scanmill {

// The compute program that does what marchOne() does, for fields with lists or without; see gpu/compute.h.
//
// Storage buffers: 0 particles (float columns, in Particles' order), 1 hit records (uint columns: bits of the way,
// triangle, outcome; with lists also the bits of a numerator and a denominator, whose quotient in m the way lacks).
// Tables: 0 the field's levels (two uvec4 each: bits of the offset and the first entry, then the bricks), 1 its table,
// 2 distances, 3 words, 4 lists, 5 triangles (three vec4 each: a corner and the two edges from it; m, relative to the
// world's origin). Parameters: MarchBlock of march_gl.cpp.
std::string marchShader(bool lists);

}  // namespace scanmill
