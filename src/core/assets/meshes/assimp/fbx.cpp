#include "assets/meshes/assimp/fbx.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>

#include "base/file.h"

namespace scanmill {

namespace {

std::uint64_t countOf(std::string_view text, std::string_view word) {
  std::uint64_t count = 0;
  for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

// Calls `change` with the index of each occurrence of `key`, which `change` may replace by text of the same length that
// does not contain `key`.
template <class Change>
void forEach(std::string& text, std::string_view key, const Change& change) {
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) change(at);
}

// Returns a string property of a binary file: its type, its length in four bytes, its text.
std::string property(std::string_view text) {
  return std::string("S") + static_cast<char>(text.size()) + std::string(3, '\0') + std::string(text);
}

// Returns the index behind the string property at `at`; the size of `text` if the property is damaged.
std::size_t behindProperty(std::string_view text, std::size_t at) {
  std::uint32_t length = 0;
  if (at + 5 > text.size() || text[at] != 'S') return text.size();
  std::memcpy(&length, text.data() + at + 1, sizeof length);
  return std::min(at + 5 + length, text.size());
}

}  // namespace

const FormatSupport& fbxFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "FBX",
      ".fbx",
      {{Read, "UpAxis UnitScaleFactor", "the unit multiplies the key `unit`; the axis holds unless `up` is given"},
       {Read, "Model Lcl* *Pivot *Offset Geometric*", "names and transforms of objects"},
       {Read, "Show Visibility", "objects with `Show` 0 are left out; with `Visibility` 0, all below them too"},
       {Read, "Vertices PolygonVertexIndex LayerElementUV LayerElementMaterial", "surfaces"},
       {Read, "Skin Cluster", "skins, in the pose in which the objects stand"},
       {Read, "Material Texture Video", "colours, opacity and images, with their scale, shift and rotation"},
       {Unused, "NodeAttribute LayerElementNormal LayerElementSmoothing Pose", "cameras, lights, normals, shading"},
       {LeftOut, "AnimationStack", "animations (the file's pose is taken)"},
       {LeftOut, "DeformPercent", "morph targets with weights"},
       {LeftOut, "NurbsSurface", "curved surfaces (NURBS)"},
       {LeftOut, "LayerElementColor", "colours of vertices"}}};
  return format;
}

std::string readFbx(const std::filesystem::path& file, LeftOut& leftOut) {
  std::string bytes = readFile(file);
  const bool binary = bytes.starts_with("Kaydara FBX Binary");
  std::uint64_t weighted = 0;
  const std::string_view object = binary ? std::string_view("\0\1", 2) : "\"";
  const auto objects = [&](const char* kind) {
    return countOf(bytes, binary ? std::string(object) + kind : std::string(object) + kind + "::");
  };
  if (objects("AnimCurve") > 0) leftOut.add("animations (the file's pose is taken)", objects("AnimStack"));
  // The geometry and its object both state this kind.
  leftOut.add("curved surfaces (NURBS)",
              (countOf(bytes, binary ? property("NurbsSurface") : "\"NurbsSurface\"") + 1) / 2);
  if (binary) {
    const std::string from = property("Visibility") + property("Visibility");
    const std::string to = property(kFbxVisibility) + property("Number");  // as long as `from`
    forEach(bytes, from, [&](std::size_t at) {
      const std::size_t value = behindProperty(bytes, behindProperty(bytes, at + from.size()));
      if (value < bytes.size() && bytes[value] == 'D') bytes.replace(at, from.size(), to);
    });
    forEach(bytes, "DeformPercentD", [&](std::size_t at) {
      double percent = 0;
      if (at + 14 + sizeof percent <= bytes.size()) std::memcpy(&percent, bytes.data() + at + 14, sizeof percent);
      if (percent != 0) ++weighted;
    });
  } else {
    forEach(bytes, "\"Visibility\"", [&](std::size_t at) {
      const std::size_t type = bytes.find_first_not_of(" \t,", at + 12);
      if (bytes.compare(std::min(type, bytes.size()), 12, "\"Visibility\"") != 0) return;
      const std::string between = bytes.substr(at + 12, type - at - 12);
      bytes.replace(at, type + 12 - at, fmt::format("\"{}\"{}\"Number\"", kFbxVisibility, between));
    });
    forEach(bytes, "DeformPercent:", [&](std::size_t at) {
      double percent = 0;
      const std::size_t from = std::min(bytes.find_first_not_of(" \t", at + 14), bytes.size());
      std::from_chars(bytes.data() + from, bytes.data() + bytes.size(), percent);
      if (percent != 0) ++weighted;
    });
  }
  leftOut.add("morph targets with weights", weighted);
  return bytes;
}

}  // namespace scanmill
