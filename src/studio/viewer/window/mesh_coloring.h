#pragma once

// Colours of a scene's triangles.

#include <array>
#include <string_view>

#include "viewer/coloring.h"
#include "viewer/frames/view_mesh.h"

namespace scanmill {

// Quantities that colours can show. Object: the placed object and the node in its file. Rule: the source of the
// class, see ViewMesh::rules.
enum class MeshColor { Class, Instance, Object, Material, Texture, Rule, Reflectance };
constexpr std::array<std::string_view, 7> kMeshColorNames{"class",   "instance", "object",     "material",
                                                          "texture", "rule",     "reflectance"};

// Returns one colour per triangle. The legend counts triangles.
Coloring colorMesh(const ViewMesh& mesh, MeshColor by);

}  // namespace scanmill
