#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "assets/meshes/assimp/parts.h"
#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"

namespace scanmill {

const FormatSupport kAc3dFormat{
    "AC3D", ".ac, .acc, .ac3d",
    "Names, transforms and surfaces of objects; objects with `subdiv` are subdivided. Colours and opacity of "
    "materials; `rgb` is taken as linear light, since AC3D states no colour space. One image for each object: the "
    "first, or the one with the role `base`, with its `texrep` and `texoff`. Files with materials of several lines "
    "(MAT) are refused",
    "lines; marks of hidden objects; objects and surfaces that the file counts and lacks"};

namespace {

// The texture of an object: its name in quotation marks, and whether it has the role `base`.
struct ObjectTexture {
  std::string quotedName;
  bool hasBaseRole = false;
};

// Parses a line's arguments "NAME" [ROLE]. Makes this texture the `chosen` one of its object if none is chosen yet, or
// if it is the first with the role `base`. Ignores a name without quotation marks.
void chooseTexture(std::string_view arguments, std::optional<ObjectTexture>& chosen) {
  const std::size_t end = arguments.starts_with('"') ? arguments.find('"', 1) : arguments.npos;
  if (end == arguments.npos || (chosen && chosen->hasBaseRole)) return;
  std::string_view role = arguments.substr(end + 1);
  const bool hasBaseRole = takeWord(role) == "base";
  if (!chosen || hasBaseRole) chosen = {std::string(arguments.substr(0, end + 1)), hasBaseRole};
}

std::uint64_t countIn(std::string_view word) {
  std::uint64_t count = 0;
  parseNumber(word, count);
  return count;
}

}  // namespace

std::string readAc3d(const std::filesystem::path& file, LeftOut& leftOut) {
  const std::string text = readFile(file);
  std::string output;
  output.reserve(text.size());
  std::optional<ObjectTexture> texture;  // texture of the current object, not written yet
  std::string transform;                 // lines `rot` and `loc` of the current object
  std::size_t objectStart = 0;           // index in `output` of the current object
  std::uint64_t objects = 0, kids = 0, surfaces = 0, statedSurfaces = 0;
  for (std::string_view unread = text; !unread.empty();) {
    const std::string_view line = takeLine(unread);
    std::string_view arguments = line;
    const std::string_view key = takeWord(arguments);
    arguments = trimmed(arguments);
    if (key == "texture") {
      chooseTexture(arguments, texture);
      continue;
    }
    // All `texture` lines of an object are adjacent, so the chosen texture is written before the next other line.
    if (texture) output += "texture " + texture->quotedName + "\n";
    texture.reset();
    if (key == "rot" || key == "loc") {
      transform.append(line) += '\n';
      continue;
    }
    if (key == "kids") {
      kids += countIn(arguments);
      if (!transform.empty()) {  // puts the object into a group with its transform, beside its kids
        output.insert(objectStart, fmt::format("OBJECT group\n{}kids {}\n", transform, countIn(arguments) + 1)) +=
            "kids 0\n";
        continue;
      }
    }
    if (key == "OBJECT") {
      ++objects;
      objectStart = output.size();
      transform.clear();
    }
    if (key == "MAT") {
      throw Error("has a material of several lines (MAT), which is not read: save it as AC3Db, or convert it to glTF");
    }
    if (key == "hidden") leftOut.add("marks of hidden objects (they are shown)");
    if (key == "numsurf") statedSurfaces += countIn(arguments);
    if (key == "refs") ++surfaces;
    output.append(line) += '\n';
  }
  if (kids + 1 > objects) leftOut.add("objects that 'kids' counts and the file lacks", kids + 1 - objects);
  if (statedSurfaces > surfaces) {
    leftOut.add("surfaces that 'numsurf' counts and the file lacks", statedSurfaces - surfaces);
  }
  return output;
}

}  // namespace scanmill
