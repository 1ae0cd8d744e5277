#pragma once

// Shapes, rotations and colours of SDF and URDF.

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

#include "assets/worlds/xml.h"
#include "scene/scene.h"

namespace scanmill {

// Returns the mesh of a <box>, <cylinder>, <cone>, <sphere>, <capsule>, <ellipsoid> or <plane>, centred at the origin;
// nullopt for any other element. Sizes are elements in SDF and attributes in URDF. Throws InputError for a size that is
// missing, not a number or not above 0.
std::optional<Mesh> solidOf(const XmlNode& shape);

// Returns the floor, the ceiling and the walls of all <polyline>s of a <geometry>, extruded along z from 0 to the
// <height> of the first one. Areas within an odd number of outlines are solid, so that an outline within another one is
// a hole. Throws InputError for a height that is not above 0, and for outlines without area or with too many points.
Mesh extrudedPolylines(const XmlNode& geometry);

// Returns the surface of a <heightmap> as Gazebo builds it: centred at <pos>, with the first row of samples at the
// greatest y. In a PNG, a JPEG or another raster without georeference, the value 0 of the first band is at z = 0, and
// the greatest value at the z of <size>. The heights of a raster with georeference count from their least value; its
// own extent replaces an absent <size>. Samples without a value leave holes. Throws an InputError that names `shape` or
// the file.
Mesh heightmapOf(const XmlNode& shape, const std::filesystem::path& file);

// Returns three sizes above 0 (m) from an element or attribute of a shape. Throws InputError for other values.
Vec3d sizesOf(const XmlNode& shape, std::string_view key);

// Returns the quaternion `q`, scaled to length 1. Throws InputError at `node` if `q` is zero.
Quat rotationOf(const XmlNode& node, const Quat& q);

// Returns red, green, blue and alpha from a text of four numbers, or of three if alpha is 1. Numbers are clamped to 0
// to 1; those above 1 are counted in `leftOut`.
std::array<float, 4> colorOf(const XmlNode& node, std::string_view text, LeftOut& leftOut);

}  // namespace scanmill
