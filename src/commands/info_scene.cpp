// `scanmill info` of scenes and 3D files prints their objects or parts, with sizes.

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "assets/asset.h"
#include "assets/meshes/gltf/reader.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/info.h"
#include "commands/table.h"
#include "config/text.h"
#include "pipeline/checks/warnings.h"
#include "scene/scene.h"
#include "scenefile/labelling.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

// Prints a table of the first kMostObjects meshes that are placed, to reveal a wrong unit or axis. A mesh has one row,
// with the size and height of its first instance.
void printObjects(const Scene& scene) {
  constexpr std::size_t kMostObjects = 30;
  std::map<std::uint32_t, std::uint64_t> copies;  // number of instances by mesh
  std::vector<const Instance*> firstCopies;
  for (const Instance& instance : scene.instances) {
    if (++copies[instance.mesh] == 1) firstCopies.push_back(&instance);
  }
  Rows rows{{"object", "size x, y, z", "lowest z (m)", "triangles", "placed"}};
  for (std::size_t i = 0; i < std::min(firstCopies.size(), kMostObjects); ++i) {
    const Instance& instance = *firstCopies[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    Box box;
    for (const Vec3f& p : mesh.positions) box.add(instance.worldFromMesh * Vec3d(p));
    if (box.empty()) continue;
    rows.push_back({instance.name, extentText(box), fmt::format("{:.5g}", box.low.z), grouped(mesh.triangles.size()),
                    grouped(copies[instance.mesh])});
  }
  printText("\n{} meshes, placed {} times\n{}", grouped(scene.meshes.size()), grouped(scene.instances.size()),
            formatTable(rows));
  if (firstCopies.size() > kMostObjects) printText("and {} more meshes\n", grouped(firstCopies.size() - kMostObjects));
}

// Returns the bounds of the static instances, since moving instances may be far away before they appear. If no instance
// is static, returns the bounds of all instances.
Box boundsAtRest(const Scene& scene) {
  Box box;
  for (const Instance& instance : scene.instances) {
    if (instance.moves()) continue;
    for (const Vec3f& p : scene.meshes[instance.mesh].positions) box.add(instance.worldFromMesh * Vec3d(p));
  }
  return box.empty() ? scene.bounds() : box;
}

void printClips(const std::filesystem::path& file) {
  const std::vector<gltf::Clip> clips = gltf::readClips(file);
  if (clips.empty()) return;
  Rows rows{{"animation", "from s", "to s"}};
  for (const gltf::Clip& c : clips)
    rows.push_back({c.name, fmt::format("{:.4g}", c.first), fmt::format("{:.4g}", c.last)});
  printText("\n{}", formatTable(rows));
  printText(
      "in a scene, `animation: {{clip: NAME}}` of the object plays an animation, and `time_s` holds it at that time\n");
}

using CountedColor = std::pair<Rgb, std::uint64_t>;  // a colour and its number of triangles

// Returns the kMostColors most frequent colours, the most frequent first. If the rule for a colour also matches a less
// frequent colour, both are counted as the former. `counts`: number of triangles by colour.
std::vector<CountedColor> joinedColors(const std::map<Rgb, std::uint64_t>& counts) {
  constexpr std::size_t kMostColors = 12;  // per material and texture, so that the table stays short
  std::vector<CountedColor> sorted(counts.begin(), counts.end());
  std::ranges::stable_sort(sorted, std::greater<>(), &CountedColor::second);
  std::vector<CountedColor> joined;
  for (const auto& [color, triangles] : sorted) {
    TriangleTraits traits;
    traits.color = color;
    const auto matching = std::ranges::find_if(joined, [&](const CountedColor& frequent) {
      Rule rule;
      rule.colors = {frequent.first};
      return matchesTriangle(rule, traits);
    });
    if (matching != joined.end()) {
      matching->second += triangles;
    } else if (joined.size() < kMostColors) {
      joined.emplace_back(color, triangles);
    }
  }
  return joined;
}

// Prints the colours of triangles that rules of a scene can match, by material and texture.
void printColors(const Asset& asset) {
  using MaterialAndTexture = std::pair<std::string, std::string>;
  std::map<MaterialAndTexture, std::map<Rgb, std::uint64_t>> trianglesByColor;
  const auto countTriangles = [&](const AssetPart& part) {
    const PartTraits traits(part, {}, false);
    auto& counts = trianglesByColor[{part.material, part.texture}];
    for (std::size_t t = 0; t < part.triangles.size(); ++t) ++counts[traits.at(t).color];
  };
  std::ranges::for_each(asset.parts, countTriangles);
  for (const InstancedParts& instanced : asset.instanced) std::ranges::for_each(instanced.parts, countTriangles);
  Rows rows{{"material", "texture", "color", "triangles"}};
  for (const auto& [names, counts] : trianglesByColor) {
    const auto& [material, texture] = names;
    for (const auto& [c, triangles] : joinedColors(counts)) {
      rows.push_back({material, texture, fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]), grouped(triangles)});
    }
  }
  printText("\n{}", formatTable(rows));
}

// A row of the table of a 3D file's parts: the names by which rules can match the part, and its size.
struct ListedPart {
  std::string node, material, texture;
  std::uint64_t triangles = 0;  // triangles in the file, without copies
  std::uint64_t placed = 0;     // number of copies that the file places
  Box box;                      // m, of all copies
};

// Prints the heading and the first kMostRows rows of a table, since a file may have tens of thousands of parts.
void printLargest(Rows rows) {
  constexpr std::size_t kMostRows = 60;
  const std::size_t omitted = rows.size() - std::min(rows.size(), 1 + kMostRows);  // the first row is the head
  rows.resize(rows.size() - omitted);
  printText("{}{}\n", formatTable(rows), omitted == 0 ? "" : fmt::format("and {} more (smaller)\n", grouped(omitted)));
}

// Prints a table of the parts with the names that rules can match and, if parts share a material and a texture, a
// second table with the sum of their triangles. Both tables are sorted by triangles, the largest number first.
// `hasCopies`: true if the column `placed` is printed.
void printParts(std::vector<ListedPart> parts, bool hasCopies) {
  struct Sum {
    std::uint64_t triangles = 0;  // triangles of all copies
    std::uint64_t parts = 0;
  };
  std::ranges::stable_sort(parts, std::greater<>(), &ListedPart::triangles);
  std::map<std::pair<std::string, std::string>, Sum> sums;  // sums by material and texture
  Rows rows{{"node", "material", "texture", "size x, y, z", "lowest z (m)", "triangles", "placed"}};
  for (const ListedPart& p : parts) {
    rows.push_back({p.node, p.material, p.texture, extentText(p.box),
                    p.box.empty() ? "" : fmt::format("{:.5g}", p.box.low.z), grouped(p.triangles), grouped(p.placed)});
    Sum& sum = sums[{p.material, p.texture}];
    sum.triangles += p.triangles * p.placed;
    ++sum.parts;
  }
  if (!hasCopies) {
    for (std::vector<std::string>& row : rows) row.pop_back();
  }
  printLargest(std::move(rows));
  if (sums.size() == parts.size()) return;
  std::vector<std::pair<std::pair<std::string, std::string>, Sum>> sorted(sums.begin(), sums.end());
  std::ranges::stable_sort(sorted, std::greater<>(), [](const auto& row) { return row.second.triangles; });
  rows = {{"material", "texture", "triangles", "parts"}};
  for (const auto& [names, sum] : sorted) {
    rows.push_back({names.first, names.second, grouped(sum.triangles), grouped(sum.parts)});
  }
  printLargest(std::move(rows));
}

}  // namespace

void printScene(const std::filesystem::path& file, std::uint64_t seed) {
  const Scene scene = readScene(file, {.seed = seed});
  const Box box = boundsAtRest(scene);
  printText("scene {}: {} triangles in memory, {} placed; {} instances, {} things\n", scene.name,
            grouped(scene.triangles()), grouped(scene.placedTriangles()), grouped(scene.instances.size()),
            grouped(scene.things()));
  printText("from [{:.2f}, {:.2f}, {:.2f}] to [{:.2f}, {:.2f}, {:.2f}] m; ontology {}\n", box.low.x, box.low.y,
            box.low.z, box.high.x, box.high.y, box.high.z, scene.ontology.name);
  if (scene.dropped.total() > 0) {
    printText("triangles left out: {} without area, {} with NaN or infinite corners, {} with indices out of range\n",
              grouped(scene.dropped.degenerate), grouped(scene.dropped.nonFinite), grouped(scene.dropped.outOfRange));
  }
  printObjects(scene);
  struct PerClass {
    std::uint64_t triangles = 0;
    std::set<std::uint32_t> instances;
  };
  std::map<std::uint16_t, PerClass> perClass;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const std::uint16_t s : mesh.surfaceOf) ++perClass[mesh.surfaces[s].semantic].triangles;
    for (const Surface& s : mesh.surfaces) {
      if (s.object != 0) perClass[s.semantic].instances.insert(instanceId(instance, s));
    }
  }
  Rows rows{{"class", "id", "triangles", "instances"}};
  for (const auto& [id, c] : perClass) {
    const SemanticClass* const semantic = scene.ontology.find(id);
    rows.push_back({semantic == nullptr ? "?" : semantic->name, std::to_string(id), grouped(c.triangles),
                    c.instances.empty() ? "" : grouped(c.instances.size())});
  }
  printText("\n{}", formatTable(rows));
  Rows materials{{"material", "reflectance", "roughness", "metallic", "texture", "source"}};
  for (const Material& m : scene.materials) {
    materials.push_back({m.name, fmt::format("{:.3f}", m.reflectance), fmt::format("{:.2f}", m.roughness),
                         fmt::format("{:.0f}", m.metallic),
                         m.texture == nullptr ? ""
                         : m.alphaTested      ? "alpha"
                                              : "colour",
                         m.source});
  }
  printText("\n{}", formatTable(materials));
  if (!scene.rules.empty()) {
    Rows rules{{"rule", "matches", "gives", "triangles"}};
    for (const RuleUse& r : scene.rules) rules.push_back({r.where.text(), r.match, r.gives, grouped(r.decided)});
    printText("\n{}", formatTable(rules));
  }
  for (const std::string& line : sizeWarnings(scene)) warn(line);
  for (const std::string& line : ruleWarnings(scene)) warn(line);
}

void printAsset(const std::filesystem::path& file, const AssetOptions& options) {
  const Asset asset = readAsset(file, options);
  std::vector<ListedPart> parts;
  std::uint64_t triangles = 0;  // triangles of all copies
  std::uint64_t nonFinite = 0;  // triangles with a corner that is NaN or infinite, each part counted once
  Box bounds;
  const auto addPart = [&](const AssetPart& part, const std::vector<Affine>& copies) {
    ListedPart& listed = parts.emplace_back(
        ListedPart{part.node, part.material, part.texture, part.triangles.size(), copies.size(), {}});
    triangles += part.triangles.size() * copies.size();
    for (const Triangle& t : part.triangles) {
      const auto isNonFinite = [&](std::uint32_t corner) { return !isFinite(part.positions[corner]); };
      if (std::ranges::any_of(t, isNonFinite)) ++nonFinite;
    }
    for (const Vec3f& p : part.positions) {
      if (!isFinite(p)) continue;
      for (const Affine& assetFromPart : copies) listed.box.add(assetFromPart * Vec3d(p));
    }
    bounds.add(listed.box);
  };
  for (const AssetPart& part : asset.parts) addPart(part, {Affine{{}, asset.origin}});
  for (const InstancedParts& instanced : asset.instanced) {
    for (const AssetPart& part : instanced.parts) addPart(part, instanced.assetFromParts);
  }
  printText("asset {}: {} triangles; labelling rules of a scene can match these names\n\n", file.string(),
            grouped(triangles));
  printParts(std::move(parts), !asset.instanced.empty());
  if (nonFinite > 0 || asset.dropped.outOfRange > 0) {
    warn("{}: scenes leave out {} triangles with NaN or infinite corners and {} with indices out of range",
         file.string(), grouped(nonFinite), grouped(asset.dropped.outOfRange));
  }
  if (bounds.empty()) return;
  printText("from [{:.8g}, {:.8g}, {:.5g}] to [{:.8g}, {:.8g}, {:.5g}]: {}\n", bounds.low.x, bounds.low.y, bounds.low.z,
            bounds.high.x, bounds.high.y, bounds.high.z, extentText(bounds));
  printText(
      "read with unit: {:g} ({}) and up: {}; change them by --unit and --up here, and by the keys `unit` and "
      "`up` of the object in a scene\n",
      options.metresPerUnit,
      asset.statedUnit > 0 ? fmt::format("times {:g} m per unit, as stated by the file or its kind", asset.statedUnit)
                           : "m per unit",
      options.up
          ? std::string(1, asset.up)
          : fmt::format("{} ({})", asset.up,
                        asset.upDeclared ? "stated by the file or its kind" : "assumed, the file does not state it"));
  if (asset.ownMiddle) printText("z up, x east and y north around {}\n", asset.system);
  if (options.textures) printColors(asset);
  const std::string suffix = lowerExtension(file);
  if (suffix == ".glb" || suffix == ".gltf") printClips(file);
}

}  // namespace scanmill
