#include "assets/meshes/assimp/collada.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/vec.h"

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

std::vector<double> numbersIn(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<double> numbers;
  for (std::size_t at = text.find_first_not_of(kBlanks); at < text.size(); at = text.find_first_not_of(kBlanks, at)) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    std::from_chars(text.data() + at, text.data() + end, numbers.emplace_back(0));
    at = end;
  }
  return numbers;
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
    const std::string_view wrap = common.substr(at, common.find("</", at) - at);
    material.clamps = material.clamps || wrap.find("WRAP") == std::string_view::npos;
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

// Returns the numbers of a `lookat` (eye, interest, up) with an up direction at right angles to the view, without which
// assimp shears; empty if the direction is right, or if there is none.
std::string levelled(std::string_view lookat) {
  const std::vector<double> n = numbersIn(lookat);
  if (n.size() != 9) return {};
  const Vec3d view{n[3] - n[0], n[4] - n[1], n[5] - n[2]};
  Vec3d up{n[6], n[7], n[8]};
  const double along = dot(view, up) / dot(view, view);
  if (!(std::abs(along) * length(view) > 1e-6 * length(up))) return {};
  up = up - view * along;
  return fmt::format("{} {} {} {} {} {} {} {} {}", n[0], n[1], n[2], n[3], n[4], n[5], up.x, up.y, up.z);
}

// Says that the images of a material use one set of the texture coordinates of a mesh (bind_vertex_input).
struct SetOfImages {
  std::string_view instance, material;  // urls of the mesh or its controller, and of the material
  std::string_view texcoord;            // the attribute of the images
  double set = 0;                       // the attribute `set` of the texture coordinates
};

// Changes to a text: what replaces a number of characters, by the index of the first.
using Edits = std::map<std::size_t, std::pair<std::size_t, std::string>>;

std::string edited(std::string_view text, const Edits& edits) {
  std::string out;
  std::size_t done = 0;
  for (const auto& [at, edit] : edits) {
    if (at < done) continue;
    out.append(text, done, at - done).append(edit.second);
    done = at + edit.first;
  }
  return out.append(text, done);
}

// Counts the nodes of a file with all copies: <instance_node> copies a node and all nodes in it, and the importer makes
// every copy.
class NodeCopies {
 public:
  void open(std::string_view id) {
    (open_.empty() ? outermost_ : nodes_[open_.back()].inner).push_back(nodes_.size());
    open_.push_back(nodes_.size());
    nodes_.emplace_back();
    if (!id.empty()) byId_.emplace(id, open_.back());
  }
  void close() {
    if (!open_.empty()) open_.pop_back();
  }
  void copy(std::string_view url) {
    if (!open_.empty() && url.starts_with('#')) nodes_[open_.back()].copied.push_back(url.substr(1));
  }

  // Returns how many nodes there are, with all copies. Throws Error if a node is copied into itself.
  double count() {
    double total = 0;
    for (const std::size_t outermost : outermost_) total += countIn(outermost);
    return total;
  }

 private:
  struct Node {
    std::vector<std::size_t> inner;
    std::vector<std::string_view> copied;
    double count = 0;  // of itself and all that is in it; 0: not yet known
    bool counting = false;
  };

  double countIn(std::size_t at) {
    if (nodes_[at].count > 0) return nodes_[at].count;
    if (nodes_[at].counting) throw Error("has a node that is copied into itself (instance_node)");
    nodes_[at].counting = true;
    double count = 1;
    for (const std::size_t inner : nodes_[at].inner) count += countIn(inner);
    for (const std::string_view id : nodes_[at].copied) {
      if (const auto found = byId_.find(id); found != byId_.end()) count += countIn(found->second);
    }
    nodes_[at].counting = false;
    return nodes_[at].count = count;
  }

  std::vector<Node> nodes_;
  std::vector<std::size_t> outermost_;
  std::vector<std::size_t> open_;
  std::map<std::string_view, std::size_t> byId_;
};

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
       {Read, "material effect diffuse transparent opaque transparency",
        "colours, images and opacity; colours are taken as linear light, as Blender writes them: COLLADA states no "
        "colour space"},
       {Read, "bind_vertex_input", "which set of texture coordinates an image uses"},
       {Read, "repeatU repeatV offsetU offsetV", "places of images, from `extra`"},
       {Unused, "library_cameras library_lights library_physics_models library_kinematics_models", "no surfaces"},
       {LeftOut, "", "morph targets with weights"},
       {LeftOut, "", "axes and units of parts of the file (`asset` in libraries)"},
       {LeftOut, "ph", "polygons with holes (ph)"},
       {LeftOut, "spline", "splines"},
       {LeftOut, "brep", "solids by their borders (brep)"},
       {LeftOut, "convex_mesh", "convex meshes (convex_mesh)"},
       {LeftOut, "", "clamped or mirrored textures (they repeat)"},
       {LeftOut, "", "images with several sets of texture coordinates (bind_vertex_input; the first is taken)"},
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
  std::map<std::string_view, std::string_view> effects;         // text, by id
  std::map<std::string_view, std::string_view> materials;       // id of the effect, by id of the material
  std::vector<std::pair<std::string_view, std::size_t>> nodes;  // the nodes that are open: ids and ends of their tags
  std::map<std::string, std::string_view> bases;                // url of a morph's base mesh, by url of its controller
  std::vector<std::string_view> urls;                           // of what skins and nodes refer to
  std::map<std::string, std::string> meshes;                    // url of a skin's mesh, by url of its controller
  std::map<std::string, std::set<double>> sets;                 // of texture coordinates, by url of the mesh
  std::string mesh;                                             // url of the last mesh
  std::vector<SetOfImages> uses;
  std::string_view instance, material;  // urls of the last ones
  NodeCopies copies;
  Edits edits;
  bool hasAxis = false;
  bool inLibrary = false;
  bool binds = false;                          // true: within <bind_material>
  std::size_t materialsAt = 0, effectsAt = 0;  // where the first material and effect may stand; 0: there are none
  const auto indexOf = [&](std::string_view part) { return static_cast<std::size_t>(part.data() - text.data()); };
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at + 1)) {
    const std::size_t end = text.find('>', at);
    if (end == std::string_view::npos) break;
    const std::size_t next = std::min(text.find('<', end), text.size());
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/", 1));
    const std::size_t content = std::min(text.find_first_not_of(" \t\r\n", end + 1), text.size() - 1);
    if (name == "node" && !tag.ends_with('/')) {
      nodes.emplace_back(attributeOf(tag, "id"), end);
      copies.open(nodes.back().first);
    } else if (name == "/node") {
      if (!nodes.empty()) nodes.pop_back();
      copies.close();
    } else if (name == "visibility") {
      const bool shown = text[content] != '0' && text.substr(content, 5) != "false";
      if (shown || nodes.empty()) continue;
      const auto& [id, behind] = nodes.back();
      const std::string known = id.empty() ? fmt::format("hidden-at-{}", behind) : std::string(id);
      if (id.empty()) edits[behind] = {0, fmt::format(" id=\"{}\"", known)};
      facts.hidden.insert(known);
    } else if (name == "library_materials" || name == "library_effects") {
      inLibrary = !tag.ends_with('/');
      std::size_t& first = name == "library_effects" ? effectsAt : materialsAt;
      if (first == 0 && inLibrary) first = end + 1;
    } else if (name == "bind_material" || name == "/bind_material") {
      binds = name[0] != '/' && !tag.ends_with('/');
    } else if (name == "technique_common" && binds && !tag.ends_with('/')) {
      edits[end + 1] = {0, "<instance_material symbol=\"!\" target=\"#!\"/>"};
    } else if (name.starts_with("library_") || name.starts_with("/library_")) {
      inLibrary = name[0] != '/' && !tag.ends_with('/');
    } else if (name == "up_axis") {
      const char up = text[content] == 'X' ? 'x' : text[content] == 'Z' ? 'z' : 'y';
      if (inLibrary && up != facts.up) facts.leftOut.add("axes and units of parts of the file (`asset` in libraries)");
      if (inLibrary || hasAxis) continue;
      hasAxis = true;
      facts.up = up;
      edits[end + 1] = {next - end - 1, fmt::format("{}_UP", up == 'x' ? 'X' : up == 'z' ? 'Z' : 'Y')};
    } else if (name == "unit") {
      const double unit = numberIn(attributeOf(tag, "meter"), 1);
      if (inLibrary && unit != (facts.unit == 0 ? 1 : facts.unit)) {
        facts.leftOut.add("axes and units of parts of the file (`asset` in libraries)");
      }
      if (!inLibrary && facts.unit == 0) facts.unit = numberIn(attributeOf(tag, "meter"), 0);
    } else if (name == "lookat") {
      const std::string_view numbers = text.substr(end + 1, next - end - 1);
      const std::string level = levelled(numbers);
      if (!level.empty()) edits[end + 1] = {numbers.size(), level};
    } else if (name == "controller") {
      const std::string_view controller = elementIn(text.substr(at), "controller").content;
      const Element morph = elementIn(controller, "morph");
      if (morph.tag.empty()) {
        meshes["#" + std::string(attributeOf(tag, "id"))] = attributeOf(elementIn(controller, "skin").tag, "source");
        continue;
      }
      bases["#" + std::string(attributeOf(tag, "id"))] = attributeOf(morph.tag, "source");
      for (std::size_t from = morph.content.find("<float_array"); from < morph.content.size();
           from = morph.content.find("<float_array", from + 1)) {
        const std::vector<double> weights = numbersIn(elementIn(morph.content.substr(from), "float_array").content);
        facts.leftOut.add("morph targets with weights",
                          weights.size() - static_cast<std::size_t>(std::count(weights.begin(), weights.end(), 0.0)));
      }
      const std::size_t behind = std::min(text.find('>', indexOf(controller) + controller.size()), text.size() - 1);
      edits[at] = {behind + 1 - at, ""};
    } else if (name == "skew" || name == "instance_image") {
      const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
      throw Error(fmt::format("has <{}> in line {}, which cannot be read: {}, or export it as glTF", name, line,
                              name == "skew" ? "bake transforms into matrices" : "export it as COLLADA 1.4.1"));
    } else if (name == "effect") {
      effects[attributeOf(tag, "id")] = elementIn(text.substr(at), "effect").content;
    } else if (name == "geometry") {
      mesh = "#" + std::string(attributeOf(tag, "id"));
    } else if (name == "input" && attributeOf(tag, "semantic") == "TEXCOORD") {
      sets[mesh].insert(numberIn(attributeOf(tag, "set"), 0));
    } else if (name == "bind_vertex_input" && attributeOf(tag, "input_semantic") == "TEXCOORD") {
      uses.push_back({instance, material, attributeOf(tag, "semantic"), numberIn(attributeOf(tag, "input_set"), 0)});
    } else if (name == "material") {
      const Element effect = elementIn(elementIn(text.substr(at), "material").content, "instance_effect");
      const std::string_view url = attributeOf(effect.tag, "url");
      materials[attributeOf(tag, "id")] = url.substr(std::min<std::size_t>(url.size(), 1));
    } else if (name == "skin") {
      urls.push_back(attributeOf(tag, "source"));
    } else if (name.starts_with("instance_")) {
      const std::string_view url = attributeOf(tag, attributeOf(tag, "url").empty() ? "target" : "url");
      urls.push_back(url);
      if (name == "instance_node") copies.copy(url);
      (name == "instance_material" ? material : instance) = url;
      if (!url.empty() && !url.starts_with('#')) facts.leftOut.add("references to other files");
    } else if (colladaFormat().has(FormatElements::Use::LeftOut, name)) {
      facts.leftOut.addKeyword(colladaFormat(), name);
    }
  }
  chargeCopies(static_cast<std::uint64_t>(std::min(copies.count(), 1e18)), {});
  for (const auto& [id, effect] : materials) {
    if (effects.contains(effect)) facts.materials.push_back(materialOf(effects[effect]));
  }
  // The importer takes the number in `texcoord` for the index of the set among those of the mesh.
  std::map<std::size_t, std::pair<std::size_t, std::set<std::size_t>>> indices;  // by where a text of `texcoord` is
  for (const SetOfImages& use : uses) {
    const std::string_view effect =
        effects[materials[use.material.substr(std::min<std::size_t>(use.material.size(), 1))]];
    std::string of(use.instance);
    for (std::size_t hops = 0; hops <= bases.size() && !sets.contains(of); ++hops) {
      const auto base = bases.find(of);
      of = base != bases.end() ? std::string(base->second) : meshes[of];
    }
    const auto set = sets[of].find(use.set);
    if (set == sets[of].end()) continue;
    const auto index = std::distance(sets[of].begin(), set);
    for (std::size_t at = effect.find("<texture"); at < effect.size(); at = effect.find("<texture", at + 1)) {
      const std::string_view texcoord = attributeOf(effect.substr(at, effect.find('>', at) - at), "texcoord");
      if (texcoord.empty() || texcoord != use.texcoord) continue;
      auto& [length, found] = indices[indexOf(texcoord)];
      length = texcoord.size();
      found.insert(static_cast<std::size_t>(index));
    }
  }
  for (const auto& [at, found] : indices) {
    edits[at] = {found.first, fmt::format("set{}", *found.second.begin())};
    if (found.second.size() == 1) continue;
    facts.leftOut.add("images with several sets of texture coordinates (bind_vertex_input; the first is taken)");
  }
  // The importer gives surfaces without a material the first one that it finds. This one is found first.
  if (materialsAt > 0 && effectsAt > 0) {
    edits[materialsAt] = {0, "<material id=\"!\" name=\"DefaultMaterial\"><instance_effect url=\"#!\"/></material>"};
    edits[effectsAt] = {
        0, "<effect id=\"!\"><profile_COMMON><technique sid=\"c\"><lambert/></technique></profile_COMMON></effect>"};
    facts.materials.insert(facts.materials.begin(), ColladaMaterial{})->colored = true;
  }
  for (const std::string_view url : urls) {
    // A base may be a controller itself.
    auto base = bases.find(std::string(url));
    for (std::size_t hops = 0; base != bases.end() && hops < bases.size(); ++hops) {
      edits[indexOf(url)] = {url.size(), std::string(base->second)};
      base = bases.find(std::string(base->second));
    }
  }
  facts.text = edited(text, edits);
  return facts;
}

}  // namespace scanmill
