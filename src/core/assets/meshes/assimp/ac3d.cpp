#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "assets/meshes/assimp/parts.h"
#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"

namespace scanmill {

const FormatSupport& ac3dFormat() {
  static const FormatSupport format{
      "AC3D",
      ".ac, .acc, .ac3d",
      {},
      "Names, transforms and surfaces of objects; objects with `subdiv` are subdivided. Colours and opacity of "
      "materials; `rgb` is taken as linear light, since AC3D states no colour space. One image for each object: the "
      "first, or the one with the role `base`, with its `texrep` and `texoff`. Files with materials of several "
      "lines (MAT) are refused",
      "lines; marks of hidden objects; objects and surfaces that the file counts and lacks"};
  return format;
}

std::string readAc3d(const std::filesystem::path& file, LeftOut& leftOut) {
  const std::string text = readFile(file);
  std::string ac3db, texture, transform;
  ac3db.reserve(text.size());
  bool hasBaseRole = false;     // true: `texture` has the role `base`
  std::size_t objectStart = 0;  // index in `ac3db` of the current object
  std::uint64_t objects = 0, kids = 0, surfaces = 0, statedSurfaces = 0;
  const auto numberIn = [](std::string_view word) {
    std::uint64_t number = 0;
    parseNumber(word, number);
    return number;
  };
  for (std::string_view unread = text; !unread.empty();) {
    const std::string_view line = takeLine(unread);
    std::string_view arguments = line;
    const std::string_view key = takeWord(arguments);
    arguments = trimmed(arguments);
    if (key == "texture") {
      const std::size_t end = arguments.starts_with('"') ? arguments.find('"', 1) : arguments.npos;
      if (end == arguments.npos || hasBaseRole) continue;  // a texture without quotation marks is none
      std::string_view role = arguments.substr(end + 1);
      hasBaseRole = takeWord(role) == "base";
      if (texture.empty() || hasBaseRole) texture = arguments.substr(0, end + 1);
      continue;
    }
    // The textures of an object follow each other: the chosen one is written before the next line of another kind.
    if (!texture.empty()) ac3db += "texture " + texture + "\n";
    texture.clear();
    hasBaseRole = false;
    if (key == "rot" || key == "loc") {
      transform.append(line) += '\n';
      continue;
    }
    if (key == "OBJECT") {
      ++objects;
      objectStart = ac3db.size();
      transform.clear();
    } else if (key == "kids") {
      kids += numberIn(arguments);
      if (!transform.empty()) {
        ac3db.insert(objectStart, fmt::format("OBJECT group\n{}kids {}\n", transform, numberIn(arguments) + 1)) +=
            "kids 0\n";
        continue;
      }
    } else if (key == "hidden") {
      leftOut.add("marks of hidden objects (they are shown)");
    } else if (key == "numsurf") {
      statedSurfaces += numberIn(arguments);
    } else if (key == "refs") {
      ++surfaces;
    } else if (key == "MAT") {
      throw Error("has a material of several lines (MAT), which is not read: save it as AC3Db, or convert it to glTF");
    }
    ac3db.append(line) += '\n';
  }
  if (kids + 1 > objects) leftOut.add("objects that 'kids' counts and the file lacks", kids + 1 - objects);
  if (statedSurfaces > surfaces) {
    leftOut.add("surfaces that 'numsurf' counts and the file lacks", statedSurfaces - surfaces);
  }
  return ac3db;
}

}  // namespace scanmill
