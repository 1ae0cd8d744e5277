#pragma once

// What an importer makes of a 3D file: plain data, which a child process hands over.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// An image that a material names.
struct ImportedMap {
  std::string name;             // as the file names it; empty: none
  std::string label;            // for people and rules
  std::uint32_t uvChannel = 0;  // the texture coordinates that it uses
  bool inverted = false;
  std::int64_t embedded = -1;  // the image of the file that it means; -1: a file of its own
};

struct ImportedMaterial {
  std::string name;
  bool stated = true;  // false: the importer made it, for what has none
  float roughness = 1;
  float metallic = 0;
  float opacity = 1;
  std::array<float, 3> color{1, 1, 1};  // linear
  ImportedMap base;                     // of the base colour
  ImportedMap opacityMap;
  // The texture coordinates that the parts of this material have.
  std::uint32_t uvChannel() const { return base.name.empty() ? opacityMap.uvChannel : base.uvChannel; }
};

// An image within the file.
struct ImportedImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;  // 0: the bytes are those of an image file; else 8 bit RGBA, the top row first
  std::string bytes;
};

// See AssetPart.
struct ImportedPart {
  std::string node;
  std::uint32_t nodeIndex = 0;
  std::uint32_t material = 0;  // index into ImportedFile::materials
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;
  std::vector<Triangle> triangles;
};

struct ImportedFile {
  char up = 'z';  // see Asset
  bool upDeclared = false;
  Vec3d origin;                  // m, what positions are relative to: see Asset
  std::uint64_t outOfRange = 0;  // triangles with indices out of range, which are left out
  std::vector<ImportedMaterial> materials;
  std::vector<ImportedImage> images;
  std::vector<ImportedPart> parts;
  std::vector<std::string> missing;  // libraries of materials that it names and that are not there
};

// For this machine and this build of the program alone.
std::string bytesOf(const ImportedFile& file);
// Throws Error where these are not the bytes of one.
ImportedFile importedFrom(std::string_view bytes);

}  // namespace scanmill
