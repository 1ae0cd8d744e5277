#pragma once

// Reads material libraries of Wavefront OBJ files (.mtl): "Appendix B2. Material Library File Format (.mtl)", with the
// physically based keys Pr and Pm.
//
//   newmtl NAME
//   Kd r [g b]                       base colour, linear; a single number is grey. A material with neither Kd nor
//   map_Kd
//                                    states no colour.
//   d [-halo] F, Tr F                opacity, or 1 - opacity
//   Pr F, Pm F                       roughness, metallic
//   map_Kd, map_d [options] FILE     image of the base colour, or of the opacity; the name may contain spaces
//
// Options -s and -o scale and shift the texture coordinates, those of map_Kd if a material has both images. Keys of the
// ambient, specular, emissive and reflected light, of bumps and of illumination are not read, since they do not say how
// a surface reflects in the near infrared.

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

  bool operator==(const UvPlace&) const = default;
};

struct ObjMaterial {
  ImportedMaterial look;
  bool defined = false;    // true: a library defines it, not only a face names it
  std::string definition;  // the statements that define it
  UvPlace base, opacity;

  bool textured() const { return !look.base.name.empty() || !look.opacityMap.name.empty(); }
};

struct Materials {
  std::vector<ObjMaterial> list;
  std::map<std::string, std::size_t> byName;
  LeftOut leftOut;

  // Returns the index of the material; adds one without colour if the name is unknown.
  std::size_t indexOf(const std::string& name);
  // Counts, after all libraries are read, what does not fit together, such as materials that faces name and no library
  // defines, if `allRead` says that the file has libraries and all were read.
  void check(bool allRead);
};

// Reads a library and adds its materials. The first definition of a name counts; other readers take the first, take the
// last or merge them. Throws InputError with the line of a statement that cannot be read.
void readLibrary(const std::filesystem::path& file, Materials& materials);

}  // namespace scanmill::obj
