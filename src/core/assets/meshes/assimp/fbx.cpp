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

// Returns the number of the property whose quoted or binary name begins at `at`; 0 if it is damaged or no number.
double numberOf(std::string_view text, std::size_t at, bool binary) {
  if (!binary) {
    const std::string_view line = text.substr(at, std::min(text.find('\n', at), text.size()) - at);
    double value = 0;
    const std::size_t from = std::min(line.find_first_not_of(" \t", line.rfind(',') + 1), line.size());
    std::from_chars(line.data() + from, line.data() + line.size(), value);
    return value;
  }
  while (at < text.size() && text[at] == 'S') at = behindProperty(text, at);
  std::int32_t value = 0;
  if (at + 1 + sizeof value > text.size() || text[at] != 'I') return 0;
  std::memcpy(&value, text.data() + at + 1, sizeof value);
  return value;
}

// Counts uses of images that assimp does not know, and collects the names of images that do not repeat.
void readImageUses(const std::string& bytes, bool binary, LeftOut& leftOut, std::set<std::string>& clamped) {
  const auto named = [&](const char* name) { return binary ? property(name) : fmt::format("\"{}\"", name); };
  const std::string texture = binary ? std::string("\0\1Texture", 9) : "Texture: ";
  for (std::size_t at = bytes.find(texture), end = 0; at != std::string::npos; at = end) {
    end = bytes.find(texture, at + 1);
    const std::string_view text = std::string_view(bytes).substr(at, end == std::string::npos ? end : end - at);
    const auto isSet = [&](const char* name) {
      const std::size_t found = text.find(named(name));
      return found != std::string_view::npos && numberOf(text, found, binary) == 1;
    };
    if (isSet("UVSwap")) leftOut.add("images with swapped texture coordinates (UVSwap)");
    if (!isSet("WrapModeU") && !isSet("WrapModeV")) continue;
    constexpr std::string_view kName = "RelativeFilename";
    const std::size_t name = std::min(text.find(kName), text.size() - kName.size()) + kName.size();
    if (binary) {
      const std::size_t behind = behindProperty(text, name);
      if (behind > name + 5) clamped.emplace(text.substr(name + 5, behind - name - 5));
    } else if (const std::size_t quote = text.find('"', name); quote != std::string_view::npos) {
      clamped.emplace(text.substr(quote + 1, text.find('"', quote + 1) - quote - 1));
    }
  }
  // A connection is a list such as "OP", the texture's number, the material's number, "DiffuseFactor".
  const std::string factor = named("DiffuseFactor");
  for (std::size_t at = bytes.find(factor); at != std::string::npos; at = bytes.find(factor, at + 1)) {
    std::string id;
    if (binary) {
      if (at > 18 && bytes[at - 18] == 'L' && bytes[at - 9] == 'L') id = "Texture" + bytes.substr(at - 18, 9);
    } else {
      const std::size_t line = bytes.rfind('\n', at) + 1;
      const std::string list = bytes.substr(line, at - line);
      const std::size_t from = list.find("\"OP\",");
      if (from != std::string::npos) id = "Texture: " + list.substr(from + 5, list.find(',', from + 5) - from - 4);
    }
    if (!id.empty() && bytes.find(id) != std::string::npos) leftOut.add("images of DiffuseFactor");
  }
}

}  // namespace

const FormatSupport& fbxFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "FBX",
      ".fbx",
      {{Read, "UpAxis FrontAxis CoordAxis UnitScaleFactor",
        "the unit multiplies the key `unit`; the axes with their signs hold unless `up` is given"},
       {Read, "Model Lcl* *Pivot *Offset Geometric*", "names and transforms of objects"},
       {Read, "Show Visibility", "objects with `Show` 0 are left out; with `Visibility` 0, all below them too"},
       {Read, "Vertices PolygonVertexIndex LayerElementUV LayerElementMaterial", "surfaces"},
       {Read, "Skin Cluster", "skins, in the pose in which the objects stand"},
       {Read, "Material Texture Video", "colours, opacity and images, with their scale and shift"},
       {Unused, "NodeAttribute LayerElementNormal LayerElementSmoothing Pose", "cameras, lights, normals, shading"},
       {LeftOut, "AnimationStack", "animations (the file's pose is taken)"},
       {LeftOut, "DeformPercent", "morph targets with weights"},
       {LeftOut, "NurbsSurface", "curved surfaces (NURBS)"},
       {LeftOut, "LayerElementColor", "colours of vertices"},
       {LeftOut, "WrapModeU WrapModeV", "clamped or mirrored textures (they repeat)"},
       {LeftOut, "Rotation", "rotations of images (Rotation)"},
       {LeftOut, "UVSwap", "images with swapped texture coordinates (UVSwap)"},
       {LeftOut, "DiffuseFactor", "images of DiffuseFactor"},
       {LeftOut, "UpAxisSign", "negative signs of the up axis (UpAxisSign)"}}};
  return format;
}

std::string readFbx(const std::filesystem::path& file, LeftOut& leftOut, std::set<std::string>& clamped) {
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
  readImageUses(bytes, binary, leftOut, clamped);
  return bytes;
}

}  // namespace scanmill
