#include "scene/labelling.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace scanmill {
namespace {

// A part that a rule gives a material keeps its own texture where that decides which beams pass: alpha cut-outs.
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

struct LabelledPart {
  const SemanticClass* semantic = nullptr;  // null: no rule gave one
  const Material* material = nullptr;       // null: the asset's own material
};

LabelledPart labelOf(const SceneBuilder& builder, const AssetPart& part, const Labelling& labelling) {
  const Verdict verdict = matchRules(labelling.rules, {part.node, part.material, part.texture, labelling.file});
  LabelledPart label;
  if (const Rule* rule = verdict.className) {
    label.semantic = &builder.ontology().require(rule->className, rule->where);
  }
  if (const Rule* rule = verdict.material) {
    label.material = &builder.library().require(rule->materialName, rule->where);
  }
  return label;
}

std::string describe(const AssetPart& part, const std::string& file) {
  return fmt::format("{}: {} ({})", file, part.node, part.material);
}

void append(Mesh& mesh, const AssetPart& part, std::uint16_t surface, bool withUvs) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  if (withUvs) {
    mesh.uvs.insert(mesh.uvs.end(), part.uvs.begin(), part.uvs.end());
    mesh.uvs.resize(mesh.positions.size());
  }
  for (const Triangle& t : part.triangles) {
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    mesh.surfaceOf.push_back(surface);
  }
}

void checkSize(const std::vector<AssetPart>& parts, const Labelling& labelling, const Location& where) {
  std::uint64_t vertices = 0;
  for (const AssetPart& part : parts) vertices += part.positions.size();
  constexpr std::uint64_t kMostVertices = std::numeric_limits<std::uint32_t>::max();
  constexpr std::size_t kMostParts = std::numeric_limits<std::uint16_t>::max();
  if (vertices > kMostVertices || parts.size() > kMostParts) {
    throw InputError(where, fmt::format("'{}' has {} parts (node and material) and {} vertices; at most {} and {} fit "
                                        "one file: split it",
                                        labelling.file, parts.size(), vertices, kMostParts, kMostVertices));
  }
}

// The mesh of some parts of the file; none where no triangle of them can be traced. `dropped` are triangles that they
// have lost already, and in the end all.
std::optional<std::uint32_t> addParts(SceneBuilder& builder, std::vector<AssetPart> parts, const Labelling& labelling,
                                      const Location& where, Dropped& dropped) {
  checkSize(parts, labelling, where);
  std::vector<LabelledPart> labels;
  std::map<std::uint32_t, std::uint32_t> objectOfNode;  // things only, numbered in the order of the nodes
  for (const AssetPart& part : parts) {
    labels.push_back(labelOf(builder, part, labelling));
    if (labels.back().semantic && labels.back().semantic->thing) objectOfNode.emplace(part.nodeIndex, 1);
  }
  if (labelling.perNode) {
    std::uint32_t number = 0;
    for (auto& [node, object] : objectOfNode) object = ++number;
  }

  Mesh mesh;
  mesh.name = labelling.file;
  std::vector<Material> materials;
  bool withUvs = false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Material& own = parts[i].fileMaterial;
    materials.push_back(labels[i].material ? withMaterial(*labels[i].material, own) : own);
    withUvs = withUvs || materials.back().texture;
  }
  std::vector<std::string> descriptions;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    AssetPart part = std::move(parts[i]);
    Surface surface;
    surface.material = builder.addMaterial(materials[i]);
    surface.semantic = labels[i].semantic ? labels[i].semantic->id : std::uint16_t{0};
    surface.object = labels[i].semantic && labels[i].semantic->thing ? objectOfNode.at(part.nodeIndex) : 0;
    surface.node = part.node;
    mesh.surfaces.push_back(std::move(surface));
    append(mesh, part, static_cast<std::uint16_t>(i), withUvs);
    descriptions.push_back(describe(part, labelling.file));
  }

  dropped += clean(mesh);
  if (mesh.triangles.empty()) return std::nullopt;
  std::vector<std::uint64_t> triangles(mesh.surfaces.size());
  for (const std::uint16_t surface : mesh.surfaceOf) ++triangles[surface];
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!labels[i].semantic && triangles[i] > 0 && !labelling.counted)
      builder.addUnlabeled(descriptions[i], triangles[i]);
  }
  return builder.addMesh(std::move(mesh));
}
}  // namespace

bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling) {
  const auto shows = [&](const AssetPart& part) {
    if (part.texture.empty()) return false;
    const LabelledPart label = labelOf(builder, part, labelling);
    return !label.material || label.material->textured;
  };
  return std::any_of(asset.parts.begin(), asset.parts.end(), shows) ||
         std::any_of(asset.instanced.begin(), asset.instanced.end(), [&](const InstancedParts& instanced) {
           return std::any_of(instanced.parts.begin(), instanced.parts.end(), shows);
         });
}

std::vector<PlacedMesh> addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling,
                                 const Location& where) {
  Dropped dropped = asset.dropped;
  std::vector<PlacedMesh> meshes;
  const auto add = [&](std::vector<AssetPart> parts, std::vector<Affine> places) {
    if (parts.empty()) return;
    std::string node = parts.front().node;
    const std::optional<std::uint32_t> mesh = addParts(builder, std::move(parts), labelling, where, dropped);
    if (mesh) meshes.push_back({*mesh, std::move(node), std::move(places)});
  };
  add(std::move(asset.parts), {});
  for (InstancedParts& instanced : asset.instanced)
    add(std::move(instanced.parts), std::move(instanced.assetFromParts));
  if (!labelling.counted) builder.addDropped(dropped);
  if (meshes.empty()) {
    throw InputError(where,
                     fmt::format("'{}' has no triangle that can be traced: {} have vertices that are not finite, "
                                 "{} no area, {} indices out of range",
                                 labelling.file, dropped.nonFinite, dropped.degenerate, dropped.outOfRange));
  }
  return meshes;
}

}  // namespace scanmill
