#pragma once

// Reads material libraries of Wavefront OBJ files (.mtl): "Appendix B2. Material Library File Format (.mtl)", with the
// physically based keys Pr and Pm.
//
//   newmtl NAME
//   Kd r [g b]                       base colour, linear; a single number is grey; with neither Kd nor map_Kd a
//                                    material states no colour
//   d [-halo] F, Tr F                opacity, or 1 - opacity
//   Pr F, Pm F                       roughness, metallic
//   map_Kd, map_d [options] FILE     image of the base colour, or of the opacity; the name may contain spaces
//
// The options -s and -o scale and shift the texture coordinates. If a material has both images, map_Kd's options hold
// for both. Other keys do not say how a surface reflects in the near infrared.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill::obj {

// Reads the statements of an OBJ file or a material library, one after the other. A statement is a line: a keyword and
// its values. A line that ends with a backslash continues in the next line. Lines that begin with # are comments.
class Statements {
 public:
  // `text` must outlive the object.
  Statements(std::string_view text, const std::filesystem::path& file);

  // Goes to the next statement. Returns false at the end of the text.
  bool next();

  std::string_view keyword() const { return keyword_; }
  // Returns the line after the keyword, without blanks at both ends but with any comment, since names may contain #.
  std::string_view rest() const { return rest_; }
  // Splits the line behind the keyword, up to a comment, into words. The result is valid until the next call.
  const std::vector<std::string_view>& words();

  // Converts a word to a number, which may be "nan" or "inf". Throws InputError with the line.
  double number(std::string_view word) const;
  // Throws an InputError that names file, line and keyword.
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  // Takes the next line of the text, and counts it.
  std::string_view nextLine();

  std::string_view text_;  // the lines that are not read yet
  std::string file_;
  int lines_ = 0;       // number of lines read so far
  int line_ = 0;        // line of the statement, counted from 1
  std::string joined_;  // the text of a statement of several lines
  std::string_view keyword_, rest_;
  std::vector<std::string_view> words_;
};

struct ObjMaterial : ImportedMaterial {
  bool defined = false;  // false: faces name the material, but no library that was read so far defines it
};

struct Materials {
  std::vector<ObjMaterial> list;
  std::map<std::string, std::size_t> byName;
  LeftOut leftOut;

  // Returns the index of the material; adds a material without a colour if the name is unknown.
  std::size_t indexOf(const std::string& name);
  // Must be called after all libraries are read. Counts materials that place their two images differently and, if the
  // file has libraries and none is missing (`isComplete`), materials that faces name but no library defines.
  void check(bool isComplete);
};

// Reads a library and adds its materials. If a name is defined twice, the first definition counts; programs differ in
// this. Throws InputError with the line of a statement that cannot be read.
void readLibrary(const std::filesystem::path& file, Materials& materials);

}  // namespace scanmill::obj
