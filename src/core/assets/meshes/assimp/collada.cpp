#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "assets/meshes/assimp/parts.h"
#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/text_scan.h"

namespace scanmill {

namespace {

// Elements that the importer cannot read or reads wrong, as XPath expressions, and what the user can do.
constexpr std::pair<const char*, const char*> kRefused[] = {
    {"//skew", "bake transforms into matrices, or convert it to glTF"},
    {"//node/lookat[..//instance_geometry or ..//instance_node]",
     "bake transforms into matrices, or convert it to glTF"},
    {"//controller/*[//instance_controller]", "convert it to glTF, for example with Blender"},
    {"//instance_image", "export it as COLLADA 1.4.1, or convert it to glTF"}};

ColladaMaterial materialOf(const pugi::xml_node& effect) {
  const pugi::xml_node common = effect.child("profile_COMMON");
  const pugi::xml_node diffuse = common.select_node(".//diffuse").node();
  const pugi::xml_node transparent = common.select_node(".//transparent").node();
  ColladaMaterial material;
  material.colored = diffuse.child("color") || diffuse.child("texture");
  if (transparent.child("texture")) {
    material.inverted = std::string_view(transparent.attribute("opaque").value()).ends_with("_ZERO");
    material.transparency = common.select_node(".//transparency/float").node().text().as_double(1);
  }
  for (const pugi::xpath_node& wrap : common.select_nodes(".//wrap_s | .//wrap_t | .//wrap_p")) {
    material.clamps = material.clamps || trimmed(wrap.node().text().get()) != "WRAP";
  }
  return material;
}

// Returns the id in a URL such as "#id".
std::string idOf(const char* url) {
  return *url == '\0' ? "" : url + 1;
}

// A COLLADA document, which read() changes for assimp.
class Collada {
 public:
  Collada(const std::filesystem::path& file, ColladaFacts& facts, LeftOut& leftOut)
      : bytes_(readFile(file)), facts_(facts), leftOut_(leftOut) {
    const pugi::xml_parse_result result = document_.load_buffer(bytes_.data(), bytes_.size());
    if (!result) {
      throw Error("is not XML: {}, in line {}; {}", result.description(), lineOf(result.offset), remedyFor(".dae"));
    }
    root_ = document_.child("COLLADA");
  }

  // Reads the facts and changes the document for assimp: its up axis, names of nodes and of sets of texture
  // coordinates, hidden nodes, and the default material.
  std::string read() {
    for (const auto& [xpath, remedy] : kRefused) {
      const pugi::xml_node refused = root_.select_node(xpath).node();
      if (!refused) continue;
      throw Error("has <{}> in line {}, which cannot be read: {}", refused.name(), lineOf(refused.offset_debug()),
                  remedy);
    }
    readAxisAndUnit();
    countUnread();
    renameUvSets();
    for (const pugi::xpath_node& node : root_.select_nodes("//node")) prepareNode(node.node());
    double nodes = 0;
    for (const pugi::xpath_node& scene : root_.select_nodes("//visual_scene")) nodes += nodesIn(scene.node());
    constexpr double kMostInInteger = 1e18;
    chargeCopies(static_cast<std::uint64_t>(std::min(nodes, kMostInInteger)), {});
    readMaterials();
    std::ostringstream text;
    document_.save(text, "", pugi::format_raw, pugi::encoding_utf8);
    return std::move(text).str();
  }

 private:
  std::ptrdiff_t lineOf(std::ptrdiff_t offset) const {
    const auto end = bytes_.begin() + std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(bytes_));
    return 1 + std::count(bytes_.begin(), end, '\n');
  }

  // Reads the file's up axis (y if it is absent or invalid) and unit. Writes the axis back into the document. Counts
  // axes and units that <asset> elements in libraries state and that differ from the file's.
  void readAxisAndUnit() {
    const auto axisOf = [](const pugi::xml_node& asset, char fallback) {
      const std::string_view text = trimmed(asset.child("up_axis").text().get());
      return text == "X_UP" ? 'x' : text == "Y_UP" ? 'y' : text == "Z_UP" ? 'z' : fallback;
    };
    const auto unitOf = [](const pugi::xml_node& asset, double fallback) {
      return asset.child("unit").attribute("meter").as_double(fallback);
    };
    const pugi::xml_node asset = root_.child("asset");
    facts_.up = axisOf(asset, 'y');
    facts_.unit = unitOf(asset, 0);
    if (pugi::xml_node axis = asset.child("up_axis")) {
      axis.text().set(facts_.up == 'x' ? "X_UP" : facts_.up == 'z' ? "Z_UP" : "Y_UP");
    }
    const double unit = facts_.unit == 0 ? 1 : facts_.unit;
    for (const pugi::xpath_node& part : root_.select_nodes("*[starts-with(name(), 'library_')]//asset")) {
      leftOut_.add("axes and units of parts of the file (`asset` in libraries)",
                   std::uint64_t{axisOf(part.node(), facts_.up) != facts_.up} +
                       std::uint64_t{unitOf(part.node(), unit) != unit});
    }
  }

  // Counts surfaces of kinds that the importer does not read, and references to other files.
  void countUnread() {
    for (const pugi::xpath_node& surface : root_.select_nodes("//ph | //spline | //brep | //convex_mesh")) {
      leftOut_.addKeyword(kColladaFormat, surface.node().name());
    }
    for (const pugi::xpath_node& instance : root_.select_nodes("//*[starts-with(name(), 'instance_')]")) {
      const std::string_view url = instance.node().attribute("url").value();
      if (!url.empty() && !url.starts_with('#')) leftOut_.add("references to other files");
    }
  }

  // Renames the sets of texture coordinates that images use, since the importer takes the first number in such a name
  // as the set's index. <bind_vertex_input> maps names to sets; indices count from the file's lowest set.
  void renameUvSets() {
    int lowestSet = std::numeric_limits<int>::max();
    for (const pugi::xpath_node& input : root_.select_nodes("//input[@semantic='TEXCOORD']")) {
      lowestSet = std::min(lowestSet, input.node().attribute("set").as_int());
    }
    std::map<std::string, std::set<int>> indices;  // set indices, by name of texture coordinates
    for (const pugi::xpath_node& use : root_.select_nodes("//bind_vertex_input[@input_semantic='TEXCOORD']")) {
      const int index = std::max(0, use.node().attribute("input_set").as_int() - lowestSet);
      indices[use.node().attribute("semantic").value()].insert(index);
    }
    for (const pugi::xpath_node& texture : root_.select_nodes("//texture[@texcoord]")) {
      pugi::xml_attribute name = texture.node().attribute("texcoord");
      const auto sets = indices.find(name.value());
      if (sets == indices.end()) continue;
      name = fmt::format("set{}", *sets->second.begin()).c_str();
      if (sets->second.size() == 1) continue;
      leftOut_.add("images with several sets of texture coordinates (bind_vertex_input; the first is taken)");
    }
  }

  // Adds a node to nodesById_, and names it by its id if it has no name. Removes the contents of an invisible node and
  // of its descendants.
  void prepareNode(pugi::xml_node node) {
    const pugi::xml_attribute id = node.attribute("id");
    nodesById_.emplace(id.value(), node);
    if (node.attribute("name").empty() && !id.empty()) node.append_attribute("name") = id.value();
    const std::string_view visible = trimmed(node.select_node("extra/technique/visibility").node().text().get());
    if (visible != "0" && visible != "false") return;
    for (const pugi::xpath_node& hidden :
         node.select_nodes("descendant-or-self::node[instance_geometry or instance_node]")) {
      leftOut_.add("hidden nodes");
      for (const char* content : {"instance_geometry", "instance_node"}) {
        while (hidden.node().remove_child(content)) continue;
      }
    }
  }

  // Returns the number of nodes below an element, including the copies that the importer makes for <instance_node>.
  // Throws Error if a node copies itself.
  double nodesIn(const pugi::xml_node& element) {
    constexpr double kBeingCounted = -1;
    double count = 0;
    for (const pugi::xml_node& node : element.children("node")) count += 1 + nodesIn(node);
    for (const pugi::xml_node& instance : element.children("instance_node")) {
      const auto original = nodesById_.find(idOf(instance.attribute("url").value()));
      if (original == nodesById_.end()) continue;
      const auto& [id, node] = *original;
      const auto [copied, isNew] = nodesInCopy_.try_emplace(id, kBeingCounted);
      if (isNew) copied->second = 1 + nodesIn(node);
      if (copied->second == kBeingCounted) throw Error("copies the node '{}' into itself", id);
      count += copied->second;
    }
    return count;
  }

  // Reads the materials. If there are any, adds kDefaultMaterial in front, since the importer gives the first material
  // to surfaces without a material.
  void readMaterials() {
    std::map<std::string, pugi::xml_node> effects;
    for (const pugi::xml_node& effect : root_.child("library_effects").children("effect")) {
      effects[effect.attribute("id").value()] = effect;
    }
    std::map<std::string, ColladaMaterial> materials;
    for (const pugi::xml_node& material : root_.child("library_materials").children("material")) {
      const auto effect = effects.find(idOf(material.child("instance_effect").attribute("url").value()));
      if (effect != effects.end()) materials[material.attribute("id").value()] = materialOf(effect->second);
    }
    if (!materials.empty()) {
      addDefaultMaterial();
      materials["!"].colored = true;  // sorts before all other ids
    }
    for (const auto& [id, material] : materials) facts_.materials.push_back(material);
  }

  // Adds kDefaultMaterial with the id "!", and binds it wherever materials are bound.
  void addDefaultMaterial() {
    pugi::xml_node effect = root_.child("library_effects").prepend_child("effect");
    effect.append_attribute("id") = "!";
    effect.append_child("profile_COMMON").append_child("technique").append_child("lambert");
    pugi::xml_node material = root_.child("library_materials").prepend_child("material");
    material.append_attribute("id") = "!";
    material.append_attribute("name") = kDefaultMaterial;
    material.append_child("instance_effect").append_attribute("url") = "#!";
    for (const pugi::xpath_node& binding : root_.select_nodes("//bind_material/technique_common")) {
      pugi::xml_node instance = binding.node().prepend_child("instance_material");
      instance.append_attribute("symbol") = "!";
      instance.append_attribute("target") = "#!";
    }
  }

  std::string bytes_;
  pugi::xml_document document_;
  pugi::xml_node root_;
  ColladaFacts& facts_;
  LeftOut& leftOut_;
  std::map<std::string, pugi::xml_node> nodesById_;
  std::map<std::string, double> nodesInCopy_;  // number of nodes that a copy of the node with this id has
};

}  // namespace

const FormatSupport kColladaFormat{
    "COLLADA",
    ".dae",
    "Names, transforms and surfaces of nodes. The unit multiplies the key `unit`; the axis holds unless the key `up` "
    "is given. Nodes with `visibility` 0 are left out with all below them. Colours, images, their places and "
    "opacity; colours are taken as linear light, as Blender writes them: COLLADA states no colour space. Files with "
    "`skew`, `lookat`, `morph` or `instance_image` are refused",
    "axes and units of parts of the file (`asset` in libraries); references to other files; further sets of texture "
    "coordinates of one image; rotations of images (rotateUV); materials without a plain diffuse colour; numbers of "
    "`transparency` beside images; animations; colours of vertices; lines; points; joints of skins that no node has",
    {.leftOut = {{"ph", "polygons with holes (ph)"},
                 {"spline", "splines"},
                 {"brep", "solids by their borders (brep)"},
                 {"convex_mesh", "convex meshes (convex_mesh)"}}}};

std::string readCollada(const std::filesystem::path& file, ColladaFacts& facts, LeftOut& leftOut) {
  return Collada(file, facts, leftOut).read();
}

}  // namespace scanmill
