#include "methods/device/traversal_shader.h"

#include "methods/device/wide_hierarchy.h"

namespace scanmill {

std::string traversalShader(const Traversal& parts) {
  return parts.head + R"( {
  uvec2 stack[)" +
         std::to_string(kMostWideDepth) + R"(];
  int top = 0;
  uvec2 open = uvec2(root, 0x80000000u);  // nodes: where they start; which are left, and which slots hold nodes
  while (true) {
    uvec2 leaves = uvec2(0u);
    if (open.y > 0x00FFFFFFu) {
      int bit = findMSB(open.y);
      uint slot = uint(31 - bit) ^ ()" +
         parts.side + R"();
      uint index = open.x + uint(bitCount(open.y & 0xFFu & ~(0xFFFFFFFFu << slot)));
      open.y &= ~(1u << bit);
      if (open.y > 0x00FFFFFFu) stack[top++] = open;
      uvec3 after;
      uint hits;
      )" +
         parts.meet +
         R"(
      open = uvec2(after.x, (hits & 0xFF000000u) | after.z);
      leaves = uvec2(after.y, hits & 0x00FFFFFFu);
    }
    while (leaves.y != 0u) {
      uint primitive = leaves.x + uint(findLSB(leaves.y));
      leaves.y &= leaves.y - 1u;
      )" +
         parts.leaf + R"(
    }
    if (open.y <= 0x00FFFFFFu) {
      if (top == 0) break;
      open = stack[--top];
    }
  }
}
)";
}

std::string boundsShader() {
  return R"(
// What is subtracted from them must not be folded into the sum.
vec3 planes(uvec3 steps, vec3 scale, vec3 origin) {
  precise vec3 bound = vec3(steps) * scale + origin;
  return bound;
}
)";
}

}  // namespace scanmill
