#pragma once

// Shapes that both SDF and URDF have.

#include <array>
#include <optional>
#include <string_view>

#include "assets/worlds/xml.h"
#include "scene/scene.h"

namespace scanmill {

// Returns the mesh of a <box>, <cylinder>, <cone>, <sphere>, <capsule>, <ellipsoid> or <plane>, centred at the origin;
// nullopt for any other element. Sizes are elements in SDF and attributes in URDF. Throws InputError for a size that is
// missing, not a number or not above 0.
std::optional<Mesh> solidOf(const XmlNode& shape);

// Returns red, green and blue, clamped to 0 to 1, from a text of three or four numbers; the fourth, alpha, is ignored.
std::array<float, 3> colorOf(const XmlNode& node, std::string_view text);

}  // namespace scanmill
