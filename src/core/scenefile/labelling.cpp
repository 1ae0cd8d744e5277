#include "scenefile/labelling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "base/error.h"
#include "base/short_text.h"
#include "images/srgb.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr std::size_t kMostSurfaces = std::numeric_limits<std::uint16_t>::max();  // of a mesh, see Mesh::surfaceOf

// Returns the material of a rule, adapted to a part whose file gives it the material `fileMaterial`. The part keeps the
// file's texture if `material` is textured, or if the texture's alpha decides which beams pass (cut-outs).
Material withTextureOf(const Material& fileMaterial, const Material& material) {
  Material adapted = material;
  adapted.textured = material.textured && fileMaterial.texture;
  if (!adapted.textured && !fileMaterial.alphaTested) return adapted;
  adapted.texture = fileMaterial.texture;
  adapted.textureMean = fileMaterial.textureMean;
  adapted.alphaTested = fileMaterial.alphaTested;
  adapted.alphaCutoff = fileMaterial.alphaCutoff;
  adapted.name = fmt::format("{} ({})", material.name, fileMaterial.name);
  return adapted;
}

// The rules that decide on a triangle: the first matching rule with a class, and the first with a material.
struct DecidingRules {
  const Rule* classRule = nullptr;     // gives the class, or drops the triangle; null: no rule does
  const Rule* materialRule = nullptr;  // gives the material; null: no rule does

  auto operator<=>(const DecidingRules&) const = default;

  // Considers the next rule that matches. Returns true if it decides on the class or the material.
  bool add(const Rule& rule) {
    const bool decidesClass = classRule == nullptr && rule.decides();
    const bool decidesMaterial = materialRule == nullptr && !rule.materialName.empty();
    if (decidesClass) classRule = &rule;
    if (decidesMaterial) materialRule = &rule;
    return decidesClass || decidesMaterial;
  }
};

// Triangles of a part on which the same rules decide.
struct LabelledPart {
  AssetPart part;
  DecidingRules rules = {};
  const SemanticClass* semantic = nullptr;  // null: no class
  std::uint32_t object = 0;                 // the number of the triangles' thing; 0 if the class is not a thing class

  bool isOfThings() const { return semantic != nullptr && semantic->thing; }
};

// Returns the indices of the rules whose name patterns match a part.
std::vector<std::size_t> rulesFor(const AssetPart& part, const Labelling& labelling) {
  std::vector<std::size_t> indices;
  for (std::size_t r = 0; r < labelling.rules.size(); ++r) {
    const Names names{.node = part.node, .material = part.material, .texture = part.texture, .file = labelling.file};
    if (matchesNames(labelling.rules[r], names)) indices.push_back(r);
  }
  return indices;
}

// Describes the class and material that a rule gives to triangles, for messages.
std::string resultOf(const Rule& rule) {
  std::string text = rule.drop ? "nothing: it drops them" : rule.className;
  if (!rule.materialName.empty()) text += (text.empty() ? "material " : ", material ") + rule.materialName;
  return text;
}

// Copies some of a part's triangles with the vertices that they use. All calls of copy() share one table of vertices,
// so that the time of a call depends only on the number of copied triangles.
class TriangleCopier {
 public:
  explicit TriangleCopier(const AssetPart& part) : part_(part), copyOf_(part.positions.size(), kNotCopied) {}

  // Returns a copy of the part, with its look and names, that has only the triangles with these indices, in this order.
  AssetPart copy(const std::vector<std::size_t>& triangles) {
    AssetPart out;
    static_cast<Look&>(out) = part_;
    out.node = part_.node;
    out.nodeIndex = part_.nodeIndex;
    out.ownClass = part_.ownClass;
    std::vector<std::uint32_t> copiedVertices;
    for (const std::size_t index : triangles) {
      Triangle triangle = part_.triangles[index];
      for (std::uint32_t& corner : triangle) {
        std::uint32_t& cornerCopy = copyOf_[corner];
        if (cornerCopy == kNotCopied) {
          cornerCopy = static_cast<std::uint32_t>(out.positions.size());
          copiedVertices.push_back(corner);
          out.positions.push_back(part_.positions[corner]);
          if (!part_.uvs.empty()) out.uvs.push_back(part_.uvs[corner]);
        }
        corner = cornerCopy;
      }
      out.triangles.push_back(triangle);
    }
    for (const std::uint32_t vertex : copiedVertices) copyOf_[vertex] = kNotCopied;
    return out;
  }

 private:
  static constexpr std::uint32_t kNotCopied = std::numeric_limits<std::uint32_t>::max();
  const AssetPart& part_;
  std::vector<std::uint32_t> copyOf_;  // by vertex of the part: its index in the current copy; or kNotCopied
};

// Divides a part into groups of triangles on which the same rules decide, and appends the groups to `labelledParts`.
// Counts the triangles of each rule in `uses`, which has one entry per rule of the labelling.
void applyRules(AssetPart part, const Labelling& labelling, const PartFrame& frame, std::vector<RuleUse>& uses,
                std::vector<LabelledPart>& labelledParts) {
  const std::vector<std::size_t> matchingRules = rulesFor(part, labelling);
  const auto rule = [&](std::size_t r) -> const Rule& { return labelling.rules[r]; };
  if (std::ranges::none_of(matchingRules, [&](std::size_t r) { return rule(r).byTriangle(); })) {
    DecidingRules deciding;
    for (const std::size_t r : matchingRules) {
      uses[r].matched += part.triangles.size();
      if (deciding.add(rule(r))) uses[r].decided += part.triangles.size();
    }
    labelledParts.push_back({std::move(part), deciding});
    return;
  }
  const bool testsSizes = std::ranges::any_of(matchingRules, [&](std::size_t r) { return rule(r).size.has_value(); });
  const PartTraits traits(part, frame, testsSizes);
  std::map<DecidingRules, std::vector<std::size_t>> groups;  // indices of the triangles
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    const TriangleTraits triangle = traits.at(t);
    DecidingRules deciding;
    for (const std::size_t r : matchingRules) {
      if (!matchesTriangle(rule(r), triangle)) continue;
      ++uses[r].matched;
      if (deciding.add(rule(r))) ++uses[r].decided;
    }
    groups[deciding].push_back(t);
  }
  TriangleCopier copier(part);
  for (const auto& [deciding, triangles] : groups) labelledParts.push_back({copier.copy(triangles), deciding});
}

// Returns the least z (m) of the corners of the parts' triangles; infinity if there are no triangles.
double lowestZ(const std::vector<AssetPart>& parts) {
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

// Appends the triangles of a part to the mesh, with the surface index `surface`. If `withUvs` is true, each vertex of
// the mesh has texture coordinates; they are zero for parts that have none.
void append(Mesh& mesh, AssetPart part, std::uint16_t surface, bool withUvs) {
  const auto firstVertex = static_cast<std::uint32_t>(mesh.positions.size());
  const auto moveTo = [](auto& target, auto& source) {
    if (target.empty()) {
      target = std::move(source);
    } else {
      target.insert(target.end(), source.begin(), source.end());
    }
  };
  moveTo(mesh.positions, part.positions);
  if (withUvs) {
    moveTo(mesh.uvs, part.uvs);
    mesh.uvs.resize(mesh.positions.size());
  }
  for (Triangle& t : part.triangles) t = {firstVertex + t[0], firstVertex + t[1], firstVertex + t[2]};
  moveTo(mesh.triangles, part.triangles);
  mesh.surfaceOf.resize(mesh.triangles.size(), surface);
}

// Throws InputError if the parts do not fit into one mesh.
void checkSize(const std::vector<LabelledPart>& parts, const Labelling& labelling, const Location& where) {
  std::uint64_t vertices = 0;
  for (const LabelledPart& p : parts) vertices += p.part.positions.size();
  constexpr std::uint64_t kMostVertices = std::numeric_limits<std::uint32_t>::max();
  if (vertices > kMostVertices || parts.size() > kMostSurfaces) {
    throw InputError(where,
                     "'{}' has {} parts (node and material) and {} vertices, but a file may have "
                     "at most {} and {}: split it",
                     labelling.file, parts.size(), vertices, kMostSurfaces, kMostVertices);
  }
}

// If a point cloud's file states labels or instances, warns of points with a thing class but without an instance.
void warnOfPointsWithoutInstance(const std::vector<ThingTriangles>& cloudParts, const std::string& file) {
  constexpr std::uint64_t kTrianglesPerPoint = 2;  // each point is a square of two triangles
  std::uint64_t pointCount = 0;
  bool hasLabels = false;
  for (const ThingTriangles& cloudPart : cloudParts) {
    hasLabels = hasLabels || !cloudPart.part->node.empty() || !cloudPart.part->ownClass.empty();
    if (cloudPart.part->node.empty()) pointCount += cloudPart.part->triangles.size() / kTrianglesPerPoint;
  }
  if (!hasLabels || pointCount == 0) return;
  warn(
      "{}: {} points of classes of things have no instance, so that those of a class count as one object: number the "
      "objects in a column `instance`, or state `instances: object` if all are one",
      file, grouped(pointCount));
}

// Splits parts that contain several things, and sets LabelledPart::object. `file` is named in messages.
std::vector<LabelledPart> divideIntoThings(std::vector<LabelledPart> parts, const ThingBounds& bounds,
                                           const std::string& file) {
  std::vector<ThingTriangles> thingParts;
  for (const LabelledPart& p : parts) {
    if (p.isOfThings()) thingParts.push_back({&p.part, p.semantic->id});
  }
  if (bounds.byClass && bounds.by == ThingBounds::By::Node) warnOfPointsWithoutInstance(thingParts, file);
  const std::vector<std::vector<std::uint32_t>> thingNumbers = numberThings(bounds, thingParts);
  std::uint32_t thingCount = 0;
  for (const std::vector<std::uint32_t>& numbers : thingNumbers) {
    if (!numbers.empty()) thingCount = std::max(thingCount, std::ranges::max(numbers));
  }
  if (bounds.by == ThingBounds::By::Part && thingCount > kMostSurfaces) {
    throw InputError(bounds.where,
                     "'{}' has {} connected things, but at most {} can get instance ids: give `instances: "
                     "node` or `instances: object`, or label less of the file with classes of things",
                     file, thingCount, kMostSurfaces);
  }
  std::vector<LabelledPart> divided;
  auto numbers = thingNumbers.begin();  // iterator to the numbers of the next part in `thingParts`
  for (LabelledPart& labelled : parts) {
    std::map<std::uint32_t, std::vector<std::size_t>> trianglesByThing;
    if (labelled.isOfThings()) {
      for (std::size_t t = 0; t < numbers->size(); ++t) trianglesByThing[(*numbers)[t]].push_back(t);
      ++numbers;
    }
    if (trianglesByThing.size() < 2) {
      if (!trianglesByThing.empty()) labelled.object = trianglesByThing.begin()->first;
      divided.push_back(std::move(labelled));
      continue;
    }
    TriangleCopier copier(labelled.part);
    for (const auto& [object, triangles] : trianglesByThing) {
      divided.push_back({copier.copy(triangles), labelled.rules, labelled.semantic, object});
    }
  }
  return divided;
}

// Returns the parts of a file, divided by rules, classes and things. `origin`: origin of the parts' frame (m, asset
// frame). `uses` counts the triangles of each rule; `dropped` counts removed triangles, which cannot be traced.
std::vector<LabelledPart> labelParts(const Ontology& ontology, std::vector<AssetPart> assetParts, const Vec3d& origin,
                                     const Labelling& labelling, std::vector<RuleUse>& uses, Dropped& dropped) {
  const PartFrame frame{origin, lowestZ(assetParts)};
  std::vector<LabelledPart> parts;
  for (AssetPart& part : assetParts) {
    // Removes triangles that cannot be traced, because such a triangle without neighbours would become a thing.
    if (labelling.things.by == ThingBounds::By::Part) {
      std::erase_if(part.triangles, [&](const Triangle& t) { return !canBeTraced(t, part.positions, dropped); });
    }
    applyRules(std::move(part), labelling, frame, uses, parts);
  }
  std::erase_if(parts, [](const LabelledPart& p) { return p.rules.classRule != nullptr && p.rules.classRule->drop; });
  for (LabelledPart& p : parts) {
    const Rule* const rule = p.rules.classRule;
    p.semantic = rule == nullptr ? ontology.find(p.part.ownClass) : &ontology.require(rule->className, rule->where);
  }
  return divideIntoThings(std::move(parts), labelling.things, labelling.file);
}

// Adds the mesh of the labelled parts of a file. Returns the mesh's index; nullopt if no triangle remains. `dropped`
// counts removed triangles, which cannot be traced.
std::optional<std::uint32_t> addMesh(SceneBuilder& builder, std::vector<LabelledPart> parts, const Labelling& labelling,
                                     Dropped& dropped) {
  Mesh mesh;
  mesh.name = labelling.file;
  std::vector<Material> materials;  // by part
  for (const LabelledPart& p : parts) {
    const Rule* const rule = p.rules.materialRule;
    const Material& fileMaterial = p.part.fileMaterial;
    materials.push_back(rule == nullptr
                            ? fileMaterial
                            : withTextureOf(fileMaterial, builder.library().require(rule->materialName, rule->where)));
  }
  const bool withUvs = std::ranges::any_of(materials, [](const Material& m) { return m.texture != nullptr; });
  std::vector<UnlabeledPart> partNames;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    AssetPart& part = parts[i].part;
    Surface surface{.material = builder.addMaterial(materials[i]),
                    .semantic = parts[i].semantic != nullptr ? parts[i].semantic->id : std::uint16_t{0},
                    .object = parts[i].object,
                    .node = part.node,
                    .texture = part.texture};
    if (const Rule* const rule = parts[i].rules.classRule) surface.labelledBy = rule->where;
    mesh.surfaces.push_back(std::move(surface));
    partNames.push_back({labelling.file, part.material, part.texture, part.node});
    append(mesh, std::move(part), static_cast<std::uint16_t>(i), withUvs);
  }

  dropped += clean(mesh);
  if (mesh.triangles.empty()) return std::nullopt;
  std::vector<std::uint64_t> trianglesByThingSurface(mesh.surfaces.size());
  for (const std::uint16_t surface : mesh.surfaceOf) ++trianglesByThingSurface[surface];
  for (std::size_t i = 0; i < parts.size() && !labelling.counted; ++i) {
    const std::uint64_t triangles = trianglesByThingSurface[i];
    if (parts[i].semantic == nullptr && triangles > 0) builder.addUnlabeled(partNames[i], triangles);
  }
  return builder.addMesh(std::move(mesh));
}

// Throws InputError for an asset of which no triangle remains, and says why. `uses` has one entry per rule.
[[noreturn]] void refuseEmpty(const Labelling& labelling, const std::vector<RuleUse>& uses, const Dropped& dropped,
                              const Location& where) {
  std::uint64_t droppedByRules = 0;
  for (std::size_t r = 0; r < labelling.rules.size(); ++r) {
    if (labelling.rules[r].drop) droppedByRules += uses[r].decided;
  }
  throw InputError(where,
                   "no triangle of '{}' remains: rules drop {} (lengths in rules are in m, after `unit`), {} "
                   "have NaN or infinite corners, {} have no area, {} have indices out of range",
                   labelling.file, droppedByRules, dropped.nonFinite, dropped.degenerate, dropped.outOfRange);
}

}  // namespace

bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling) {
  const auto showsTexture = [&](const AssetPart& part) {
    if (part.texture.empty()) return false;
    for (const std::size_t r : rulesFor(part, labelling)) {
      const Rule& rule = labelling.rules[r];
      if (rule.materialName.empty()) continue;
      if (builder.library().require(rule.materialName, rule.where).textured) return true;
      if (!rule.byTriangle()) return false;  // the rule sets the material of all triangles that are left
    }
    return true;
  };
  return std::ranges::any_of(asset.parts, showsTexture) ||
         std::ranges::any_of(asset.instanced, [&](const InstancedParts& instanced) {
           return std::ranges::any_of(instanced.parts, showsTexture);
         });
}

std::vector<PlacedMesh> addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling,
                                 const Location& where) {
  // Rules by box, height, slope or size test positions in the asset's frame, so all instances must first be turned into
  // parts in that frame.
  if (std::ranges::any_of(labelling.rules, [](const Rule& r) { return r.box || r.height || r.slope || r.size; })) {
    flatten(asset);
  }
  InstancedParts singleParts{std::move(asset.parts), {}};
  if (length(asset.origin) > 0) singleParts.assetFromParts = {Affine{{}, asset.origin}};
  asset.instanced.insert(asset.instanced.begin(), std::move(singleParts));
  Dropped dropped = asset.dropped;
  std::vector<RuleUse> uses;  // by rule
  for (const Rule& rule : labelling.rules) uses.push_back({rule.where, describe(rule), resultOf(rule)});
  std::vector<PlacedMesh> meshes;
  for (InstancedParts& group : asset.instanced) {
    if (group.parts.empty()) continue;
    std::string node = group.parts.front().node;
    // An asset with an origin has no instances, so there is a single group, to which the origin applies.
    std::vector<LabelledPart> labelledParts =
        labelParts(builder.ontology(), std::move(group.parts), asset.origin, labelling, uses, dropped);
    checkSize(labelledParts, labelling, where);
    if (const auto mesh = addMesh(builder, std::move(labelledParts), labelling, dropped)) {
      meshes.push_back({*mesh, std::move(node), std::move(group.assetFromParts)});
    }
  }
  if (!labelling.counted) {
    builder.addDropped(dropped);
    for (const RuleUse& use : uses) builder.countRule(use);
  }
  if (meshes.empty()) refuseEmpty(labelling, uses, dropped, where);
  return meshes;
}

PartTraits::PartTraits(const AssetPart& part, const PartFrame& frame, bool withSizes) : part_(part), frame_(frame) {
  if (!withSizes) return;
  const ConnectedParts connected = connect({&part});
  for (const std::uint32_t number : connected.numbers.front()) {
    const Vec3d size = connected.boxes[number].high - connected.boxes[number].low;
    sizes_.push_back(std::max({size.x, size.y, size.z}));
  }
}

// Returns the base colour at the triangle's centre: the part's colour times the colour of its texture.
Rgb PartTraits::colorAt(const Triangle& triangle) const {
  std::array<double, 3> linear{part_.color[0], part_.color[1], part_.color[2]};
  const Texture* const texture = part_.fileMaterial.texture.get();
  if (part_.fileMaterial.textured && texture != nullptr && !part_.uvs.empty()) {
    Vec2f centre{0, 0};
    for (const std::uint32_t corner : triangle) {
      centre.x += part_.uvs[corner].x / 3;
      centre.y += part_.uvs[corner].y / 3;
    }
    const std::uint8_t* const texel = texture->texel(centre.x, centre.y);
    for (std::size_t c = 0; c < 3; ++c) linear[c] *= linearOf(texel[c] / 255.0);
  }
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(srgbOf(linear[c]), 0.0, 1.0)));
  }
  return color;
}

TriangleTraits PartTraits::at(std::size_t triangle) const {
  const Triangle& corners = part_.triangles[triangle];
  TriangleTraits traits;
  traits.color = colorAt(corners);
  for (const std::uint32_t corner : corners) traits.middle += Vec3d(part_.positions[corner]) * (1.0 / 3);
  traits.height = traits.middle.z - frame_.lowest;
  traits.middle += frame_.origin;
  const Vec3d a(part_.positions[corners[0]]);
  const Vec3d normal = cross(Vec3d(part_.positions[corners[1]]) - a, Vec3d(part_.positions[corners[2]]) - a);
  traits.slope = std::atan2(std::hypot(normal.x, normal.y), std::fabs(normal.z));
  if (!sizes_.empty()) traits.size = sizes_[triangle];
  return traits;
}

}  // namespace scanmill
