#include "assets/meshes/assimp/fbx.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

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

// Returns the text of the property whose quoted or binary name begins at `at`.
std::string_view textOf(std::string_view text, std::size_t at, bool binary) {
  if (binary) {
    for (int i = 0; i < 4; ++i) at = behindProperty(text, at);  // its name, type, label and flags
    const std::size_t behind = behindProperty(text, at);
    return behind > at + 5 ? text.substr(at + 5, behind - at - 5) : std::string_view();
  }
  const std::string_view line = text.substr(at, std::min(text.find('\n', at), text.size()) - at);
  const std::size_t end = std::max<std::size_t>(line.rfind('"'), 1);
  const std::size_t from = line.rfind('"', end - 1) + 1;
  return line.substr(from, end - from);
}

// Returns a name as it stands in a list of properties.
std::string named(const char* name, bool binary) {
  return binary ? property(name) : fmt::format("\"{}\"", name);
}

// True if the first property of this name is 1.
bool isSet(std::string_view text, const char* name, bool binary) {
  const std::size_t found = text.find(named(name, binary));
  return found != std::string_view::npos && numberOf(text, found, binary) == 1;
}

struct Object {
  std::string id;    // its number, as connections write it
  std::string kind;  // "LodGroup", for example
  std::size_t at = 0;
  std::string_view text;  // from `at` to the next object of its class
};

// Returns the objects of a class, such as "Model".
std::vector<Object> objectsOf(std::string_view bytes, bool binary, const std::string& name) {
  const std::string key = binary ? static_cast<char>(name.size()) + name + 'L' : name + ": ";
  std::vector<Object> objects;
  for (std::size_t at = bytes.find(key), next = 0; at < bytes.size(); at = next) {
    next = std::min(bytes.find(key, at + 1), bytes.size());
    Object object{"", "", at, bytes.substr(at, next - at)};
    if (binary) {
      const std::size_t kind = behindProperty(object.text, key.size() + 8);
      const std::size_t behind = behindProperty(object.text, kind);
      object.id = object.text.substr(key.size() - 1, 9);
      if (behind > kind + 5) object.kind = object.text.substr(kind + 5, behind - kind - 5);
    } else {
      const std::string_view line = object.text.substr(0, object.text.find('\n'));
      const std::size_t quote = line.rfind('"');
      const std::size_t open = line.rfind('"', quote - 1) + 1;
      if ((at > 0 && std::string_view(" \t\r\n").find(bytes[at - 1]) == std::string_view::npos) ||
          quote == std::string_view::npos || quote < open)
        continue;
      object.id = line.substr(key.size(), line.find(',') - key.size());
      object.kind = line.substr(open, quote - open);
    }
    objects.push_back(object);
  }
  return objects;
}

// Returns the numbers of the two objects of a connection, as Object::id, whose type "OO" or "OP" begins at `at`.
std::pair<std::string, std::string> connected(std::string_view bytes, std::size_t at, bool binary) {
  const std::string_view text = bytes.substr(std::min(at + (binary ? 7 : 4), bytes.size()));
  if (binary)
    return {std::string(text.substr(0, 9)), std::string(text.substr(std::min<std::size_t>(9, text.size()), 9))};
  constexpr std::string_view kBetween = ", \t\r\n";
  std::array<std::string, 2> ids;
  std::size_t end = 0;
  for (std::string& id : ids) {
    const std::size_t from = std::min(text.find_first_not_of(kBetween, end), text.size());
    end = std::min(text.find_first_of(kBetween, from), text.size());
    id = text.substr(from, end - from);
  }
  return {ids[0], ids[1]};
}

// Keeps the first object below each LodGroup, the finest. The importer ignores connections of the type "PP".
void cutCoarserLevels(std::string& bytes, bool binary, const std::vector<Object>& models, LeftOut& leftOut) {
  std::set<std::string> ids;
  std::map<std::string, bool> groups;  // true: has its first object
  for (const Object& model : models) {
    ids.insert(model.id);
    if (model.kind == "LodGroup") groups[model.id] = false;
  }
  if (groups.empty()) return;
  forEach(bytes, named("OO", binary), [&](std::size_t at) {
    const auto [id, parent] = connected(bytes, at, binary);
    const auto group = groups.find(parent);
    if (group == groups.end() || !ids.contains(id) || !std::exchange(group->second, true)) return;
    bytes.replace(at + (binary ? 5 : 1), 2, "PP");
    leftOut.add("coarser levels of detail (LodGroup)");
  });
}

// Counts objects that have other materials than the first object with the same mesh.
void countSharedMeshes(const std::string& bytes, bool binary, const std::vector<Object>& models, LeftOut& leftOut) {
  std::map<std::string, std::vector<std::string>> materials;  // by object
  std::set<std::string> meshIds, materialIds;
  for (const Object& model : models) materials[model.id];
  for (const Object& mesh : objectsOf(bytes, binary, "Geometry")) meshIds.insert(mesh.id);
  for (const Object& material : objectsOf(bytes, binary, "Material")) materialIds.insert(material.id);
  std::vector<std::pair<std::string, std::string>> uses;  // of meshes by objects
  const std::string link = named("OO", binary);
  for (std::size_t at = bytes.find(link); at != std::string::npos; at = bytes.find(link, at + 1)) {
    const auto [id, parent] = connected(bytes, at, binary);
    const auto model = materials.find(parent);
    if (model == materials.end()) continue;
    if (meshIds.contains(id)) uses.emplace_back(id, parent);
    if (materialIds.contains(id)) model->second.push_back(id);
  }
  std::map<std::string, std::string> first;  // object by mesh
  for (const auto& [mesh, model] : uses) {
    if (materials[model] != materials[first.emplace(mesh, model).first->second]) {
      leftOut.add("materials of objects with a mesh of another object (they have the materials of that)");
    }
  }
}

// Counts uses of images that assimp does not know, and reads how images are used.
void readImageUses(const std::string& bytes, bool binary, LeftOut& leftOut, FbxImages& images) {
  std::set<std::string> ids;
  for (const Object& texture : objectsOf(bytes, binary, "Texture")) {
    const std::string_view text = texture.text;
    ids.insert(texture.id);
    if (isSet(text, "UVSwap", binary)) leftOut.add("images with swapped texture coordinates (UVSwap)");
    constexpr std::string_view kName = "RelativeFilename";
    const std::size_t at = std::min(text.find(kName), text.size() - kName.size()) + kName.size();
    std::string name;
    if (binary) {
      const std::size_t behind = behindProperty(text, at);
      if (behind > at + 5) name = text.substr(at + 5, behind - at - 5);
    } else if (const std::size_t quote = text.find('"', at); quote != std::string_view::npos) {
      name = text.substr(quote + 1, text.find('"', quote + 1) - quote - 1);
    }
    if (name.empty()) continue;
    if (isSet(text, "WrapModeU", binary) || isSet(text, "WrapModeV", binary)) images.clamped.insert(name);
    const std::size_t found = text.find(named("UVSet", binary));
    if (found == std::string_view::npos) continue;
    std::string_view set = textOf(text, found, binary);
    if (set == "default") set = {};
    if (const auto [known, isNew] = images.uvSets.emplace(name, set); !isNew && known->second != set) {
      leftOut.add("images with several sets of texture coordinates (UVSet; the first is taken)");
    }
  }
  // A connection is a list such as "OP", the texture's number, the material's number, "DiffuseFactor".
  const std::string factor = named("DiffuseFactor", binary);
  for (std::size_t at = bytes.find(factor); at != std::string::npos; at = bytes.find(factor, at + 1)) {
    const std::size_t line = bytes.rfind('\n', at) + 1;
    const std::size_t type = binary ? at - 25 : bytes.rfind("\"OP\"", at);
    if (!binary && (type == std::string::npos || type < line)) continue;
    if (type < at && ids.contains(connected(bytes, type, binary).first)) leftOut.add("images of DiffuseFactor");
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
       {Read, "InheritType", "how objects inherit the scale of their parents; absent: 0"},
       {Read, "PreRotation PostRotation RotationOrder",
        "where `RotationActive` is 1 and `RotationSpaceForLimitOnly` 0"},
       {Read, "Mesh Vertices PolygonVertexIndex LayerElementUV LayerElementMaterial", "surfaces"},
       {Read, "Skin Cluster", "skins, in the pose in which the objects stand"},
       {Read, "Material Texture Video UVSet",
        "colours, opacity and images, with their scale, shift and set of coordinates; colours are taken as linear "
        "light, as in Blender, since FBX states no colour space"},
       {Unused, "NodeAttribute LayerElementNormal LayerElementSmoothing Pose", "cameras, lights, normals, shading"},
       {Unused, "Shape Line NurbsCurve", "shapes of morph targets, lines (which are counted) and curves"},
       {LeftOut, "AnimationStack", "animations (the file's pose is taken)"},
       {LeftOut, "DeformPercent", "morph targets with weights"},
       {LeftOut, "NurbsSurface TrimNurbsSurface", "curved surfaces (NURBS)"},
       {LeftOut, "Patch", "curved surfaces (Patch)"},
       {LeftOut, "Boundary", "borders of curved surfaces (Boundary)"},
       {LeftOut, "LodGroup", "coarser levels of detail (LodGroup)"},
       {LeftOut, "", "scales that objects inherit from sheared or flat parents (InheritType)"},
       {LeftOut, "LayerElementColor", "colours of vertices"},
       {LeftOut, "WrapModeU WrapModeV", "clamped or mirrored textures (they repeat)"},
       {LeftOut, "Rotation", "rotations of images (Rotation)"},
       {LeftOut, "", "materials of objects with a mesh of another object (they have the materials of that)"},
       {LeftOut, "", "images with several sets of texture coordinates (UVSet; the first is taken)"},
       {LeftOut, "", "sets of texture coordinates that meshes lack (UVSet; their first is taken)"},
       {LeftOut, "UVSwap", "images with swapped texture coordinates (UVSwap)"},
       {LeftOut, "DiffuseFactor", "images of DiffuseFactor"},
       {LeftOut, "UpAxisSign", "negative signs of the up axis (UpAxisSign)"}}};
  return format;
}

std::string readFbx(const std::filesystem::path& file, LeftOut& leftOut, FbxImages& images) {
  std::string bytes = readFile(file);
  const bool binary = bytes.starts_with("Kaydara FBX Binary");
  std::uint64_t weighted = 0;
  const std::string_view object = binary ? std::string_view("\0\1", 2) : "\"";
  const auto objects = [&](const char* kind) {
    return countOf(bytes, binary ? std::string(object) + kind : std::string(object) + kind + "::");
  };
  if (objects("AnimCurve") > 0) leftOut.add("animations (the file's pose is taken)", objects("AnimStack"));
  for (const Object& geometry : objectsOf(bytes, binary, "Geometry")) {
    if (!geometry.kind.empty()) leftOut.addKeyword(fbxFormat(), geometry.kind);
  }
  const std::vector<Object> models = objectsOf(bytes, binary, "Model");
  cutCoarserLevels(bytes, binary, models, leftOut);
  countSharedMeshes(bytes, binary, models, leftOut);
  // The importer applies these three to every object.
  for (const Object& model : models) {
    if (isSet(model.text, "RotationActive", binary) && !isSet(model.text, "RotationSpaceForLimitOnly", binary))
      continue;
    for (const char* name : {"PreRotation", "PostRotation", "RotationOrder"}) {
      const std::size_t found = model.text.find(named(name, binary));
      if (found != std::string_view::npos) bytes[model.at + found + (binary ? 5 : 1)] = '_';
    }
  }
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
  readImageUses(bytes, binary, leftOut, images);
  return bytes;
}

}  // namespace scanmill
