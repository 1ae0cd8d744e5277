#include "scenefile/labelling.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "base/error.h"
#include "base/short_text.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr std::size_t kMostSurfaces = std::numeric_limits<std::uint16_t>::max();  // largest number of surfaces of a
                                                                                  // mesh

// Returns the material `material` of a rule, adapted to a part whose file gives it the material `own`. The part keeps
// the texture of `own` if `material` is textured, or if the texture's alpha decides which beams pass (cut-outs).
Material withMaterial(const Material& material, const Material& own) {
  Material m = material;
  m.textured = material.textured && own.texture;
  if (!m.textured && !own.alphaTested) return m;
  m.texture = own.texture;
  m.textureMean = own.textureMean;
  m.alphaTested = own.alphaTested;
  m.alphaCutoff = own.alphaCutoff;
  m.name = fmt::format("{} ({})", material.name, own.name);
  return m;
}

// Triangles of a part that all get their class from the same rule and their material from the same rule.
struct LabelledPart {
  AssetPart part;
  const Rule* classRule = nullptr;  // null if no rule gives these triangles a class or drops them
  const Rule* materialRule = nullptr;
  const SemanticClass* semantic = nullptr;  // null: no class
  std::uint32_t object = 0;                 // the number of the triangles' thing; 0 if the class is not a thing class

  bool isOfThings() const { return semantic != nullptr && semantic->thing; }
};

// Returns the indices of the rules whose name patterns match a part.
std::vector<std::size_t> rulesFor(const AssetPart& part, const Labelling& labelling) {
  std::vector<std::size_t> found;
  for (std::size_t r = 0; r < labelling.rules.size(); ++r) {
    if (matchesNames(labelling.rules[r], {part.node, part.material, part.texture, labelling.file})) found.push_back(r);
  }
  return found;
}

// Sets `classRule` to the rule if it is null and the rule gives a class or drops triangles, and `materialRule` if it is
// null and the rule gives a material. Returns true if one of them was set.
bool decide(const Rule& rule, const Rule*& classRule, const Rule*& materialRule) {
  const bool decides = rule.decides() && classRule == nullptr;
  const bool covers = !rule.materialName.empty() && materialRule == nullptr;
  if (decides) classRule = &rule;
  if (covers) materialRule = &rule;
  return decides || covers;
}

// Describes the class and material that a rule gives to triangles, for messages.
std::string gives(const Rule& rule) {
  std::string text = rule.drop ? "nothing: it drops them" : rule.className;
  if (!rule.materialName.empty()) text += (text.empty() ? "material " : ", material ") + rule.materialName;
  return text;
}

// Copies some of a part's triangles with the vertices that they use. All calls of copy() share one table of vertices,
// so that the time of a call depends only on the number of copied triangles.
class TriangleCopier {
 public:
  explicit TriangleCopier(const AssetPart& part) : part_(part), copyOf_(part.positions.size(), kNotCopied) {}

  AssetPart copy(const std::vector<std::size_t>& triangles) {
    AssetPart out;
    out.node = part_.node;
    out.nodeIndex = part_.nodeIndex;
    out.material = part_.material;
    out.texture = part_.texture;
    out.fileMaterial = part_.fileMaterial;
    out.color = part_.color;
    out.ownClass = part_.ownClass;
    std::vector<std::uint32_t> touched;
    for (const std::size_t number : triangles) {
      Triangle t = part_.triangles[number];
      for (std::uint32_t& corner : t) {
        std::uint32_t& to = copyOf_[corner];
        if (to == kNotCopied) {
          to = static_cast<std::uint32_t>(out.positions.size());
          touched.push_back(corner);
          out.positions.push_back(part_.positions[corner]);
          if (!part_.uvs.empty()) out.uvs.push_back(part_.uvs[corner]);
        }
        corner = to;
      }
      out.triangles.push_back(t);
    }
    for (const std::uint32_t corner : touched) copyOf_[corner] = kNotCopied;
    return out;
  }

 private:
  static constexpr std::uint32_t kNotCopied = std::numeric_limits<std::uint32_t>::max();
  const AssetPart& part_;
  std::vector<std::uint32_t> copyOf_;  // by vertex of the part: its number in the copy; kNotCopied: not copied yet
};

// Appends a part to `out`, divided into groups of triangles with the same rules; counts the triangles of each rule.
void applyRules(AssetPart part, const Labelling& labelling, const PartFrame& frame, std::vector<RuleUse>& uses,
                std::vector<LabelledPart>& out) {
  const std::vector<std::size_t> named = rulesFor(part, labelling);
  const auto rule = [&](std::size_t r) -> const Rule& { return labelling.rules[r]; };
  if (std::ranges::none_of(named, [&](std::size_t r) { return rule(r).byTriangle(); })) {
    LabelledPart undivided;
    for (const std::size_t r : named) {
      uses[r].matched += part.triangles.size();
      if (decide(rule(r), undivided.classRule, undivided.materialRule)) uses[r].decided += part.triangles.size();
    }
    undivided.part = std::move(part);
    out.push_back(std::move(undivided));
    return;
  }
  const PartTraits traits(part, frame,
                          std::ranges::any_of(named, [&](std::size_t r) { return rule(r).size.has_value(); }));
  std::map<std::pair<const Rule*, const Rule*>, std::vector<std::size_t>> groups;
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    const TriangleTraits own = traits.at(t);
    const Rule* classRule = nullptr;
    const Rule* materialRule = nullptr;
    for (const std::size_t r : named) {
      if (!matchesTriangle(rule(r), own)) continue;
      ++uses[r].matched;
      if (decide(rule(r), classRule, materialRule)) ++uses[r].decided;
    }
    groups[{classRule, materialRule}].push_back(t);
  }
  TriangleCopier copier(part);
  for (const auto& [rules, triangles] : groups) out.push_back({copier.copy(triangles), rules.first, rules.second});
}

// Returns the least z (m) of the parts' triangles.
double lowestOf(const std::vector<AssetPart>& parts) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const AssetPart& part : parts) {
    for (const Triangle& t : part.triangles) {
      for (const std::uint32_t corner : t) {
        if (isFinite(part.positions[corner])) lowest = std::min(lowest, static_cast<double>(part.positions[corner].z));
      }
    }
  }
  return lowest;
}

// Appends the triangles of a part to the mesh, with the surface of this index.
void append(Mesh& mesh, AssetPart part, std::uint16_t surface, bool withUvs) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto take = [](auto& to, auto& from) {
    if (to.empty()) {
      to = std::move(from);
    } else {
      to.insert(to.end(), from.begin(), from.end());
    }
  };
  take(mesh.positions, part.positions);
  if (withUvs) {
    take(mesh.uvs, part.uvs);
    mesh.uvs.resize(mesh.positions.size());
  }
  for (Triangle& t : part.triangles) t = {first + t[0], first + t[1], first + t[2]};
  take(mesh.triangles, part.triangles);
  mesh.surfaceOf.resize(mesh.triangles.size(), surface);
}

void checkSize(const std::vector<LabelledPart>& parts, const Labelling& labelling, const Location& where) {
  std::uint64_t vertices = 0;
  for (const LabelledPart& p : parts) vertices += p.part.positions.size();
  constexpr std::uint64_t kMostVertices = std::numeric_limits<std::uint32_t>::max();
  if (vertices > kMostVertices || parts.size() > kMostSurfaces) {
    throw InputError(
        where,
        fmt::format(
            "'{}' has {} parts (node and material) and {} vertices, but a file may have at most {} and {}: split it",
            labelling.file, parts.size(), vertices, kMostSurfaces, kMostVertices));
  }
}

// Warns of a cloud's points that are of thing classes, but have no instance, if the file states labels or instances.
void warnOfPointsWithoutInstance(const std::vector<ThingTriangles>& triangles, const std::string& file) {
  std::uint64_t without = 0;
  bool stated = false;
  for (const ThingTriangles& t : triangles) {
    stated = stated || !t.part->node.empty() || !t.part->ownClass.empty();
    if (t.part->node.empty()) without += t.part->triangles.size() / 2;
  }
  if (!stated || without == 0) return;
  warn(fmt::format(
      "{}: {} points of classes of things have no instance, so that those of a class count as one object: number the "
      "objects in a column `instance`, or state `instances: object` if all are one",
      file, grouped(without)));
}

// Splits parts that contain several things, and sets LabelledPart::object.
std::vector<LabelledPart> dividedThings(std::vector<LabelledPart> parts, const ThingBounds& bounds,
                                        const std::string& file) {
  std::vector<ThingTriangles> ofThings;
  for (const LabelledPart& p : parts) {
    if (p.isOfThings()) ofThings.push_back({&p.part, p.semantic->id});
  }
  if (bounds.byClass && bounds.by == ThingBounds::By::Node) warnOfPointsWithoutInstance(ofThings, file);
  const std::vector<std::vector<std::uint32_t>> numbers = numberThings(bounds, ofThings);
  std::uint32_t things = 0;
  for (const std::vector<std::uint32_t>& own : numbers) {
    if (!own.empty()) things = std::max(things, *std::ranges::max_element(own));
  }
  if (bounds.by == ThingBounds::By::Part && things > kMostSurfaces) {
    throw InputError(bounds.where,
                     fmt::format("'{}' has {} connected things, but at most {} can get instance ids: give `instances: "
                                 "node` or `instances: object`, or label less of the file with classes of things",
                                 file, things, kMostSurfaces));
  }
  std::vector<LabelledPart> divided;
  auto ownNumbers = numbers.begin();
  for (LabelledPart& labelled : parts) {
    std::map<std::uint32_t, std::vector<std::size_t>> trianglesOf;  // by number of the thing
    if (labelled.isOfThings()) {
      for (std::size_t t = 0; t < ownNumbers->size(); ++t) trianglesOf[(*ownNumbers)[t]].push_back(t);
      ++ownNumbers;
    }
    if (trianglesOf.size() < 2) {
      if (!trianglesOf.empty()) labelled.object = trianglesOf.begin()->first;
      divided.push_back(std::move(labelled));
      continue;
    }
    TriangleCopier copier(labelled.part);
    for (const auto& [object, triangles] : trianglesOf) {
      divided.push_back({copier.copy(triangles), labelled.classRule, labelled.materialRule, labelled.semantic, object});
    }
  }
  return divided;
}

// Gives parts of a file their rules, classes and things. Counts in `dropped` the triangles that cannot be traced.
std::vector<LabelledPart> labelled(const Ontology& ontology, std::vector<AssetPart> assetParts, const Vec3d& origin,
                                   const Labelling& labelling, std::vector<RuleUse>& uses, Dropped& dropped) {
  const PartFrame frame{origin, lowestOf(assetParts)};
  std::vector<LabelledPart> parts;
  for (AssetPart& part : assetParts) {
    // Removes triangles that cannot be traced, because such a triangle without neighbours would become a thing.
    if (labelling.things.by == ThingBounds::By::Part) {
      std::erase_if(part.triangles, [&](const Triangle& t) { return !canBeTraced(t, part.positions, dropped); });
    }
    applyRules(std::move(part), labelling, frame, uses, parts);
  }
  std::erase_if(parts, [](const LabelledPart& p) { return p.classRule != nullptr && p.classRule->drop; });
  for (LabelledPart& p : parts) {
    const Rule* const rule = p.classRule;
    p.semantic = rule == nullptr ? ontology.find(p.part.ownClass) : &ontology.require(rule->className, rule->where);
  }
  return dividedThings(std::move(parts), labelling.things, labelling.file);
}

// Adds the mesh of the labelled parts of a file. Returns the mesh's index; nullopt if no triangle remains. Counts in
// `dropped` the triangles that cannot be traced.
std::optional<std::uint32_t> addMesh(SceneBuilder& builder, std::vector<LabelledPart> parts, const Labelling& labelling,
                                     Dropped& dropped) {
  Mesh mesh;
  mesh.name = labelling.file;
  std::vector<Material> materials;
  bool withUvs = false;
  for (const LabelledPart& p : parts) {
    const Material& own = p.part.fileMaterial;
    const Rule* const rule = p.materialRule;
    materials.push_back(rule ? withMaterial(builder.library().require(rule->materialName, rule->where), own) : own);
    withUvs = withUvs || materials.back().texture;
  }
  std::vector<UnlabeledPart> names;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    AssetPart& part = parts[i].part;
    Surface surface;
    surface.material = builder.addMaterial(materials[i]);
    surface.semantic = parts[i].semantic != nullptr ? parts[i].semantic->id : std::uint16_t{0};
    surface.object = parts[i].object;
    surface.node = part.node;
    surface.texture = part.texture;
    if (parts[i].classRule != nullptr) surface.labelledBy = parts[i].classRule->where;
    mesh.surfaces.push_back(std::move(surface));
    names.push_back({labelling.file, part.material, part.texture, part.node});
    append(mesh, std::move(part), static_cast<std::uint16_t>(i), withUvs);
  }

  dropped += clean(mesh);
  if (mesh.triangles.empty()) return std::nullopt;
  std::vector<std::uint64_t> triangles(mesh.surfaces.size());
  for (const std::uint16_t surface : mesh.surfaceOf) ++triangles[surface];
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (parts[i].semantic == nullptr && triangles[i] > 0 && !labelling.counted)
      builder.addUnlabeled(names[i], triangles[i]);
  }
  return builder.addMesh(std::move(mesh));
}

}  // namespace

bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling) {
  const auto shows = [&](const AssetPart& part) {
    if (part.texture.empty()) return false;
    for (const std::size_t r : rulesFor(part, labelling)) {
      const Rule& rule = labelling.rules[r];
      if (!rule.colors.empty()) return true;
      if (rule.materialName.empty()) continue;
      const bool textured = builder.library().require(rule.materialName, rule.where).textured;
      if (textured || !rule.byTriangle()) return textured;
    }
    return true;
  };
  return std::ranges::any_of(asset.parts, shows) ||
         std::ranges::any_of(asset.instanced, [&](const InstancedParts& instanced) {
           return std::ranges::any_of(instanced.parts, shows);
         });
}

std::vector<PlacedMesh> addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling,
                                 const Location& where) {
  // Rules by box, height, slope or size test positions in the asset's frame, so all instances must first be turned into
  // parts in that frame.
  if (std::ranges::any_of(labelling.rules, [](const Rule& r) { return r.box || r.height || r.slope || r.size; })) {
    flatten(asset);  // flatten() ignores Asset::origin: assets with an origin have no instances
  }
  Dropped dropped = asset.dropped;
  std::vector<RuleUse> uses;
  for (const Rule& rule : labelling.rules) uses.push_back({rule.where, describe(rule), gives(rule)});
  std::vector<PlacedMesh> meshes;
  const auto add = [&](std::vector<AssetPart> parts, const Vec3d& origin, std::vector<Affine> places) {
    if (parts.empty()) return;
    std::string node = parts.front().node;
    std::vector<LabelledPart> labelledParts =
        labelled(builder.ontology(), std::move(parts), origin, labelling, uses, dropped);
    checkSize(labelledParts, labelling, where);
    const std::optional<std::uint32_t> mesh = addMesh(builder, std::move(labelledParts), labelling, dropped);
    if (mesh) meshes.push_back({*mesh, std::move(node), std::move(places)});
  };
  const bool moved = length(asset.origin) > 0;
  add(std::move(asset.parts), asset.origin, moved ? std::vector{Affine{{}, asset.origin}} : std::vector<Affine>{});
  for (InstancedParts& instanced : asset.instanced) {
    add(std::move(instanced.parts), {}, std::move(instanced.assetFromParts));
  }
  if (!labelling.counted) {
    builder.addDropped(dropped);
    for (const RuleUse& use : uses) builder.countRule(use);
  }
  if (meshes.empty()) {
    std::uint64_t byRules = 0;
    for (std::size_t r = 0; r < labelling.rules.size(); ++r) {
      if (labelling.rules[r].drop) byRules += uses[r].decided;
    }
    throw InputError(
        where, fmt::format("no triangle of '{}' remains: rules drop {} (lengths in rules are in m, after `unit`), {} "
                           "have NaN or infinite corners, {} have no area, {} have indices out of range",
                           labelling.file, byRules, dropped.nonFinite, dropped.degenerate, dropped.outOfRange));
  }
  return meshes;
}

}  // namespace scanmill
