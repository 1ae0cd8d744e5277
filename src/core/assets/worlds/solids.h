#pragma once

// Shapes that SDF and URDF share.

#include <array>
#include <optional>
#include <string_view>

#include "assets/worlds/xml.h"
#include "scene/scene.h"

namespace scanmill {

// <box>, <cylinder>, <cone>, <sphere>, <capsule>, <ellipsoid> or <plane>, about its own origin; their sizes are
// elements in SDF and attributes in URDF. Nothing for what is none of these. Throws InputError for a size that is
// missing, no number or not above 0.
std::optional<Mesh> solidOf(const XmlNode& shape);

// Red, green, blue and alpha, 0 to 1; without alpha.
std::array<float, 3> colorOf(const XmlNode& node, std::string_view text);

}  // namespace scanmill
