#pragma once

// Reads material libraries of Wavefront OBJ files (.mtl): "Appendix B2. Material Library File Format (.mtl)", with the
// physically based keys Pr and Pm.
//
//   newmtl NAME
//   Kd r [g b]                       base colour, linear; a single number is grey
//   d [-halo] F, Tr F                opacity, or 1 - opacity
//   Pr F, Pm F                       roughness, metallic
//   map_Kd, map_d [options] FILE     image of the base colour, or of the opacity; the name may contain spaces
//
// Options -s and -o scale and shift the texture coordinates. Keys of the ambient, specular, emissive and reflected
// light, of bumps and of illumination are not read, since they do not say how a surface reflects in the near infrared.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill::obj {

// How texture coordinates are placed on an image: uv * scale + offset.
struct UvPlace {
  Vec2f scale{1, 1};
  Vec2f offset{0, 0};
};

struct Materials {
  std::vector<ImportedMaterial> materials;
  std::vector<UvPlace> uvs;  // by index of the material
  std::map<std::string, std::size_t> byName;
  LeftOut leftOut;
};

// Reads a library and adds its materials; the first definition of a name counts. Throws InputError with the line of a
// statement that cannot be read.
void readLibrary(const std::filesystem::path& file, Materials& materials);

}  // namespace scanmill::obj
