#pragma once

// Shapes, rotations and colours that both SDF and URDF have.

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

// Returns three sizes above 0 (m) from an element or attribute of a shape. Throws InputError for others.
Vec3d sizesOf(const XmlNode& shape, std::string_view key);

// Returns the quaternion, scaled to length 1. Throws InputError if it is zero.
Quat rotationOf(const XmlNode& node, const Quat& q);

// Returns red, green, blue and alpha from a text of four numbers, or of three if alpha is 1. Numbers are clamped to 0
// to 1; those above 1 are counted in `leftOut`.
std::array<float, 4> colorOf(const XmlNode& node, std::string_view text, LeftOut& leftOut);

}  // namespace scanmill
