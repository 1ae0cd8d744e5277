#pragma once

// GLSL that goes down a WideHierarchy (wide_hierarchy.h).

#include <string>

namespace scanmill {

// The parts of a function in which a caller differs from others.
struct Traversal {
  std::string head;  // "void search(uint root)": the node to begin with is `root`
  // Sets `uint hits` to the children of node `index` that are to be visited: bits 24 to 31 nodes, by the order of the
  // visit, the first highest: bit 31 - (slot ^ side); bits 0 to 23 primitives of leaves. And `uvec3 after` to the
  // node's firstNode and firstPrimitive, and its `inner`, above which bits 8 to 23 are the caller's.
  std::string meet;
  std::string side;  // of the node whose children stand in `open`: which slots come first
  std::string leaf;  // what happens to `primitive`
};

std::string traversalShader(const Traversal& parts);

// GLSL: `vec3 planes(uvec3 steps, vec3 scale, vec3 origin)`, bounds of children as wideBound() gives them.
std::string boundsShader();

}  // namespace scanmill
