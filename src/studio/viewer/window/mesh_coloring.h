#pragma once

// Colours of a scene's triangles.

#include <array>
#include <string_view>

#include "viewer/coloring.h"
#include "viewer/frames/view_mesh.h"

namespace scanmill {

enum class MeshColor { Class, Instance, Material, Reflectance };
constexpr std::array<std::string_view, 4> kMeshColorNames{"class", "instance", "material", "reflectance"};

// One colour per triangle. The legend counts triangles.
Coloring colorMesh(const ViewMesh& mesh, MeshColor by);

}  // namespace scanmill
