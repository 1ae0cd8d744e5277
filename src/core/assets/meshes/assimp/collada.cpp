#include "assets/meshes/assimp/collada.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

namespace {

// Returns the value of an attribute in the text of a tag; empty if the tag does not have it.
std::string_view attributeOf(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    const std::size_t equals = tag.find_first_not_of(" \t\r\n", at + name.size());
    if (at == 0 || tag.find_first_of(" \t\r\n", at - 1) != at - 1 || equals == std::string_view::npos) continue;
    const std::size_t quote = tag.find_first_not_of(" \t\r\n", equals + 1);
    if (tag[equals] != '=' || quote == std::string_view::npos) continue;
    return tag.substr(quote + 1, tag.find(tag[quote], quote + 1) - quote - 1);
  }
  return {};
}

double numberIn(std::string_view text, double fallback) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  std::from_chars(text.data(), text.data() + text.size(), fallback);
  return fallback;
}

struct Element {
  std::string_view tag;      // without its angle brackets; empty: there is no such element
  std::string_view content;  // the text between its tags
};

// Returns the first element of this name in a text.
Element elementIn(std::string_view text, const std::string& name) {
  for (std::size_t at = text.find("<" + name); at != std::string_view::npos; at = text.find("<" + name, at + 1)) {
    const std::size_t end = text.find('>', at);
    if (end == std::string_view::npos) return {};
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    if (tag.substr(0, tag.find_first_of(" \t\r\n/")) != name) continue;
    if (tag.ends_with('/')) return {tag, {}};
    return {tag, text.substr(end + 1, std::min(text.find("</" + name, end), text.size()) - end - 1)};
  }
  return {};
}

// Reads an effect, whose text is given.
ColladaMaterial materialOf(std::string_view effect) {
  const std::string_view common = elementIn(effect, "profile_COMMON").content;
  const std::string_view diffuse = elementIn(common, "diffuse").content;
  const Element transparent = elementIn(common, "transparent");
  ColladaMaterial material;
  material.colored = !elementIn(diffuse, "color").tag.empty() || !elementIn(diffuse, "texture").tag.empty();
  if (!elementIn(transparent.content, "texture").tag.empty()) {
    material.inverted = attributeOf(transparent.tag, "opaque").ends_with("_ZERO");
    material.transparency = numberIn(elementIn(elementIn(common, "transparency").content, "float").content, 1);
  }
  for (std::size_t at = common.find("<wrap_"); at != std::string_view::npos; at = common.find("<wrap_", at + 1)) {
    for (const char* axis : {"wrap_s", "wrap_t"}) {
      const std::string_view wrap = elementIn(common.substr(at, 40), axis).content;
      material.clamps = material.clamps || (!wrap.empty() && wrap.find("WRAP") == std::string_view::npos);
    }
  }
  return material;
}

// Replaces comments by blanks, so that the numbers of lines stay.
void blankComments(std::string& text) {
  for (std::size_t at = text.find("<!--"); at != std::string::npos; at = text.find("<!--", at)) {
    const std::size_t end = std::min(text.find("-->", at), text.size() - 3) + 3;
    for (; at < end; ++at) text[at] = text[at] == '\n' ? '\n' : ' ';
  }
}

}  // namespace

const FormatSupport& colladaFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "COLLADA",
      ".dae",
      {{Read, "unit up_axis", "the unit multiplies the key `unit`; the axis holds unless the key `up` is given"},
       {Read, "node instance_node matrix translate rotate scale lookat", "names and transforms of nodes"},
       {Read, "visibility", "nodes with 0 are left out with all below them"},
       {Read, "triangles trifans tristrips polylist polygons", "surfaces"},
       {Read, "skin bind_shape_matrix joints vertex_weights", "skins, in the pose in which the nodes stand"},
       {Read, "material effect diffuse transparent opaque transparency", "colours, images and opacity"},
       {Read, "repeatU repeatV offsetU offsetV", "places of images, from `extra`"},
       {Unused, "library_cameras library_lights library_physics_models library_kinematics_models", "no surfaces"},
       {LeftOut, "ph", "polygons with holes (ph)"},
       {LeftOut, "spline", "splines"},
       {LeftOut, "brep", "solids by their borders (brep)"},
       {LeftOut, "convex_mesh", "convex meshes (convex_mesh)"},
       {LeftOut, "", "clamped or mirrored textures (they repeat)"},
       {LeftOut, "", "rotations of images (rotateUV)"},
       {LeftOut, "", "materials without a plain diffuse colour"},
       {LeftOut, "", "numbers of `transparency` beside images (the images alone count)"},
       {LeftOut, "", "references to other files"},
       {Unused, "skew instance_image", "files with these are refused"}}};
  return format;
}

ColladaFacts colladaFacts(const std::filesystem::path& file) {
  std::string bytes = readFile(file);
  blankComments(bytes);
  const std::string_view text = bytes;
  ColladaFacts facts;
  std::map<std::string_view, ColladaMaterial> effects;
  std::map<std::string_view, std::string_view> materials;  // id of the effect, by id of the material
  std::vector<std::string_view> nodes;                     // ids of the nodes that are open
  bool hasAxis = false;
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at + 1)) {
    const std::size_t end = std::min(text.find('>', at), text.size());
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/", 1));
    const std::size_t content = std::min(text.find_first_not_of(" \t\r\n", end + 1), text.size() - 1);
    if (name == "node" && !tag.ends_with('/')) {
      nodes.push_back(attributeOf(tag, "id"));
    } else if (name == "/node") {
      if (!nodes.empty()) nodes.pop_back();
    } else if (name == "visibility") {
      const bool shown = text[content] != '0' && text.substr(content, 5) != "false";
      if (!shown && !nodes.empty() && !nodes.back().empty()) facts.hidden.emplace(nodes.back());
    } else if (name == "up_axis" && !hasAxis) {
      hasAxis = true;
      facts.up = text[content] == 'X' ? 'x' : text[content] == 'Z' ? 'z' : 'y';
    } else if (name == "unit" && facts.unit == 0) {
      const std::string_view meter = attributeOf(tag, "meter");
      std::from_chars(meter.data(), meter.data() + meter.size(), facts.unit);
    } else if (name == "skew" || name == "instance_image") {
      const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
      throw Error(fmt::format("has <{}> in line {}, which cannot be read: {}, or export it as glTF", name, line,
                              name == "skew" ? "bake transforms into matrices" : "export it as COLLADA 1.4.1"));
    } else if (name == "effect") {
      effects[attributeOf(tag, "id")] = materialOf(elementIn(text.substr(at), "effect").content);
    } else if (name == "material") {
      const Element effect = elementIn(elementIn(text.substr(at), "material").content, "instance_effect");
      const std::string_view url = attributeOf(effect.tag, "url");
      materials[attributeOf(tag, "id")] = url.substr(std::min<std::size_t>(url.size(), 1));
    } else if (name.starts_with("instance_")) {
      const std::string_view url = attributeOf(tag, attributeOf(tag, "url").empty() ? "target" : "url");
      if (!url.empty() && !url.starts_with('#')) facts.leftOut.add("references to other files");
    } else if (colladaFormat().has(FormatElements::Use::LeftOut, name)) {
      facts.leftOut.addKeyword(colladaFormat(), name);
    }
  }
  for (const auto& [id, effect] : materials) {
    if (effects.contains(effect)) facts.materials.push_back(effects[effect]);
  }
  return facts;
}

}  // namespace scanmill
