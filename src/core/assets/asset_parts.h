#pragma once

// What readers of assets share.

#include <cstdint>
#include <vector>

#include "assets/asset.h"

namespace scanmill {

// A file may place its meshes any number of times, so a small file can ask for any amount of memory.
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 28;

// The rotation that takes an up axis to z. x-up follows COLLADA: y points left to -x, z to the viewer.
Mat3 zUpFrom(char up);

// Some kinds come in with three vertices of their own for every triangle: joins those that are bit-identical.
void weld(std::vector<Vec3f>& positions, std::vector<Vec2f>& uvs, std::vector<Triangle>& triangles);

// Moves a part by a transform that is not singular; what that mirrors still faces outwards.
void move(AssetPart& part, const Affine& place);

// Of all that is finite, copies too.
Box boundsOf(const Asset& asset);

// Makes copies of Asset::instanced parts like any others, each a node of its own.
void flatten(Asset& asset);

}  // namespace scanmill
