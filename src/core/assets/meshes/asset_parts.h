#pragma once

// Helpers that the readers of assets share.

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "base/format_support.h"

namespace scanmill {

// Largest number of triangles of an asset. Without it, a small file could place its meshes any number of times and so
// require any amount of memory.
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 28;

// Memory (bytes) that a copy of a triangle takes in a scene, with its vertices and its share of the hierarchy.
constexpr double kBytesPerTriangle = 128;

// Returns the rotation from an up axis ('x', 'y' or 'z') to z. x-up follows COLLADA: y becomes -x, z becomes -y.
Mat3 zUpFrom(char up);

// Returns the transform from the coordinates of a file to the asset's frame: metres, z up.
Mat3 assetFromFile(char up, double metresPerUnit);

// Returns an origin near most of `count` positions (m), which position(i) returns: the median along each axis of at
// most 2000 of them, which ignores outliers, in whole metres, or 0 along axes on which it is small. Positions that are
// not finite are ignored.
Vec3d originNear(std::size_t count, const std::function<Vec3d(std::size_t)>& position);

// Removes vertices that no triangle of the part uses, and merges bit-identical ones, since some kinds of files have
// three separate vertices for every triangle.
void weld(AssetPart& part);

// Makes a triangle of each three vertices of a part without triangles, and welds them.
void makeTriangles(AssetPart& part);

// Vertices and triangles in the frame of a node.
struct Geometry {
  std::vector<Vec3d> points;
  std::vector<Vec2f> uvs;  // empty, or one per point; v = 0 is the image's bottom row
  std::vector<Triangle> triangles;
  std::uint64_t dropped = 0;  // number of triangles with indices out of range
};

// Appends geometry to the part of its material (a number) among the parts of a node, which are those from the index
// `first` on; adds the part if there is none. If the material needs texture coordinates, geometry without them is a
// part of its own. If the transform mirrors, triangles are flipped and still face outwards.
void append(const Geometry& geometry, const Affine& assetFromNode, std::uint32_t material, bool needsUvs,
            std::size_t first, std::vector<AssetPart>& parts);

// Names and numbers the parts of a node, which are those from the index `first` on, welds them, and removes those
// without triangles.
void finishNode(std::string_view name, std::uint32_t nodeIndex, std::size_t first, std::vector<AssetPart>& parts);

// Transforms a part. The transform must not be singular; if it mirrors, triangles are flipped and still face outwards.
void move(AssetPart& part, const Affine& transform);

// Takes the texture off a part without texture coordinates, since a single texel would colour all of it, and counts the
// part in `leftOut`. The mean colour of the image remains. Also counts a part whose texture coordinates leave an image
// that the file does not repeat (`repeats` is false), since images always repeat here.
void checkTexture(AssetPart& part, bool repeats, LeftOut& leftOut);

// Returns the bounds of all finite vertices in the asset's frame (m), including those of Asset::instanced.
Box boundsOf(const Asset& asset);

// Replaces Asset::instanced by copies of its parts in Asset::parts. Each copy becomes a separate node.
void flatten(Asset& asset);

}  // namespace scanmill
