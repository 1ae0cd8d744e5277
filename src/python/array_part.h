#pragma once

// Objects of a scene that Python gives as arrays. The module scanmill.parts checks the arrays before they come here.

#include <string>
#include <vector>

#include "scene/builder.h"

namespace scanmill {

// One class, material and thing of a part's triangles.
struct ArraySurface {
  std::string className, material;
  float reflectance = -1;    // replaces the material's; negative: the material's own
  std::int64_t object = -1;  // see Surface::object; negative: 1 for a class of things, 0 for a class of stuff
};

struct ArrayPart {
  std::string name;
  Mesh mesh;                           // without surfaces
  std::vector<ArraySurface> surfaces;  // Mesh::surfaceOf indexes them
  Affine worldFromMesh;
};

// Adds the parts to a scene. Throws an InputError that names the part, for a name that the scene or another part has
// already, and for unknown classes and materials.
void addParts(SceneBuilder& builder, const std::vector<ArrayPart>& parts);

}  // namespace scanmill
