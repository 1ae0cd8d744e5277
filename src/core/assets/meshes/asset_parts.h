#pragma once

// Helpers that the readers of assets share.

#include <cstdint>
#include <string_view>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "base/format_support.h"

namespace scanmill {

// Largest number of triangles of an asset. Without this limit, a small file could require any amount of memory by
// placing its meshes many times.
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 28;

// Memory (bytes) that a copy of a triangle takes in a scene, with its vertices and its share of the hierarchy.
constexpr double kBytesPerTriangle = 128;

// Returns the rotation from an up axis ('x', 'y' or 'z') to z. x-up follows COLLADA: y becomes -x, z becomes -y.
Mat3 zUpFrom(char up);

// Returns the transform from the coordinates of a file to the asset's frame: metres, z up.
Mat3 assetFromFile(char up, double metresPerUnit);

// Transforms the positions of a file that states no up axis to the asset's axes, in metres, and sets Asset::up. If
// `exact`, the positions have more digits than float32 has: sets Asset::origin to a point near most of them. Along each
// axis it is the median of at most 2000 of the positions, in whole metres; 0 if the median is small. Outliers hardly
// move the median. Positions that are not finite are ignored.
void placePositions(std::vector<Vec3d>& positions, bool exact, const AssetOptions& options, Asset& asset);

// Removes vertices that no triangle of the part uses, and merges bit-identical ones, since some kinds of files have
// three separate vertices for every triangle. Parts that share vertices already may stay as they are.
void weld(AssetPart& part);

// Makes a triangle of every three successive vertices of a part without triangles, and welds the part.
void makeTriangles(AssetPart& part);

// Vertices and triangles in the frame of a node.
struct Geometry {
  std::vector<Vec3d> points;
  std::vector<Vec2f> uvs;  // empty, or one per point; v = 0 is the image's bottom row
  std::vector<Triangle> triangles;
  std::uint64_t dropped = 0;  // number of triangles with indices out of range
};

// Appends geometry to the node's part with this material number, and adds the part if there is none. The node's parts
// are parts[first] and all after it. If `needsUvs`, geometry with and without texture coordinates goes to separate
// parts. If the transform mirrors, flips triangles so that they still face outwards.
void append(const Geometry& geometry, const Affine& assetFromNode, std::uint32_t material, bool needsUvs,
            std::size_t first, std::vector<AssetPart>& parts);

// Names, numbers and welds the parts of a node, which are parts[first] and all after it. Removes parts without
// triangles.
void finishNode(std::string_view name, std::uint32_t nodeIndex, std::size_t first, std::vector<AssetPart>& parts);

// Transforms a part. The transform must not be singular. If it mirrors, flips triangles, so that they face outwards.
void move(AssetPart& part, const Affine& transform);

// Removes the texture of a part without texture coordinates, since a single texel would colour the complete part, and
// counts the part in `leftOut`. The mean colour of the image remains. Also counts a part with texture coordinates
// outside of 0 to 1 if the file clamps or mirrors its image (`repeats` is false), since scenes repeat every image.
void checkTexture(AssetPart& part, bool repeats, LeftOut& leftOut);

// Returns the bounds of all finite vertices in the asset's frame (m), including those of Asset::instanced.
Box boundsOf(const Asset& asset);

// Replaces Asset::instanced by copies in Asset::parts, each as a new node. Asset::origin must be 0 if there are copies.
void flatten(Asset& asset);

}  // namespace scanmill
