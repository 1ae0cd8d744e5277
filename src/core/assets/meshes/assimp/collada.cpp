#include "assets/meshes/assimp/collada.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <vector>

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
       {Read, "material effect diffuse transparent transparency", "colours, images and opacity"},
       {Read, "repeatU repeatV offsetU offsetV rotateUV", "places of images, from `extra`"},
       {Unused, "library_cameras library_lights library_physics_models library_kinematics_models", "no surfaces"},
       {LeftOut, "ph", "polygons with holes (ph)"},
       {LeftOut, "spline", "splines"},
       {LeftOut, "brep", "solids by their borders (brep)"},
       {LeftOut, "convex_mesh", "convex meshes (convex_mesh)"},
       {LeftOut, "", "references to other files"}}};
  return format;
}

ColladaFacts colladaFacts(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  const std::string_view text = bytes;
  ColladaFacts facts;
  std::vector<std::string_view> nodes;  // ids of the nodes that are open
  bool hasAxis = false;
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at + 1)) {
    if (text.substr(at, 4) == "<!--") {
      at = std::min(text.find("-->", at), text.size());
      continue;
    }
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
    } else if (name.starts_with("instance_")) {
      const std::string_view url = attributeOf(tag, attributeOf(tag, "url").empty() ? "target" : "url");
      if (!url.empty() && !url.starts_with('#')) facts.leftOut.add("references to other files");
    } else if (colladaFormat().has(FormatElements::Use::LeftOut, name)) {
      facts.leftOut.addKeyword(colladaFormat(), name);
    }
  }
  return facts;
}

}  // namespace scanmill
