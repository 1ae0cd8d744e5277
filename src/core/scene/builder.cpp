#include "scene/builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/hash.h"
#include "base/random.h"

namespace scanmill {

SceneBuilder::SceneBuilder(std::string name, std::uint64_t seed, Ontology ontology, MaterialLibrary library)
    : library_(std::move(library)) {
  scene_.name = std::move(name);
  scene_.seed = seed;
  scene_.ontology = std::move(ontology);
  const auto tableDefault = std::ranges::find(library_.materials, "default", &Material::name);
  scene_.materials.push_back(tableDefault != library_.materials.end() ? *tableDefault : Material{.name = "default"});
}

std::uint16_t SceneBuilder::material(std::string_view name, const Location& where) {
  return addMaterial(library_.require(name, where));
}

void SceneBuilder::drawReflectances() {
  for (Material& m : library_.materials) {
    if (m.least >= m.greatest) continue;
    // The material's name, not its index, selects the random numbers, so that the order of the table does not matter.
    const RandomBlock random =
        randomBlock({.seed = scene_.seed, .beam = fnv1a(m.name), .purpose = Purpose::Reflectance});
    const double limit = uniform(random[1]) < 0.5 ? m.least : m.greatest;
    m.reflectance = static_cast<float>(m.reflectance * std::pow(limit / m.reflectance, uniform(random[0])));
  }
}

std::uint16_t SceneBuilder::addMaterial(const Material& material) {
  const auto same = std::ranges::find(scene_.materials, material);
  if (same != scene_.materials.end()) return static_cast<std::uint16_t>(same - scene_.materials.begin());
  if (scene_.materials.size() > std::numeric_limits<std::uint16_t>::max()) {
    throw InputError("the scene has more than 65536 materials: merge them with rules that name a material");
  }
  scene_.materials.push_back(material);
  return static_cast<std::uint16_t>(scene_.materials.size() - 1);
}

Surface SceneBuilder::surface(std::string_view className, std::string_view materialName, const Location& where) {
  const SemanticClass& semantic = scene_.ontology.require(className, where);
  return {.material = material(materialName, where), .semantic = semantic.id, .object = semantic.thing ? 1u : 0u};
}

std::uint32_t SceneBuilder::addMesh(Mesh mesh) {
  const bool fits = mesh.surfaceOf.size() == mesh.triangles.size() &&
                    (mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size()) &&
                    std::ranges::all_of(mesh.surfaceOf, [&](std::uint16_t s) { return s < mesh.surfaces.size(); });
  if (!fits) throw Error("mesh '{}': surfaces or texture coordinates do not fit its triangles", mesh.name);
  scene_.dropped += clean(mesh);
  mesh.objects = 0;
  for (const Surface& s : mesh.surfaces) mesh.objects = std::max(mesh.objects, s.object);
  scene_.meshes.push_back(std::move(mesh));
  return static_cast<std::uint32_t>(scene_.meshes.size() - 1);
}

Instance& SceneBuilder::place(std::uint32_t mesh, const Affine& worldFromMesh, std::string name, const Location& where,
                              std::shared_ptr<const Movement> movement, std::shared_ptr<const Animation> animation,
                              const std::string& thing) {
  const Mat3& linear = worldFromMesh.linear;
  if (!isFinite(linear.x) || !isFinite(linear.y) || !isFinite(linear.z) || !isFinite(worldFromMesh.translation)) {
    throw InputError(where, "the transform of '{}' is not finite", name);
  }
  if (isSingular(linear)) {
    throw InputError(where, "the transform of '{}' flattens it: no scale may be zero", name);
  }
  std::uint32_t objects = scene_.meshes.at(mesh).objects;  // number of new instance ids
  if (animation != nullptr) {
    for (const std::uint32_t moment : animation->meshes) objects = std::max(objects, scene_.meshes.at(moment).objects);
  }
  if (objects > std::numeric_limits<std::uint32_t>::max() - nextInstanceId_) {
    throw InputError(where, "the scene holds more than 4294967294 things, beyond what instance ids can tell apart");
  }
  std::uint32_t id = objects > 0 ? nextInstanceId_ : 0;
  if (objects > 0 && !thing.empty()) {
    if (objects > 1) {
      throw InputError(where,
                       "'{}' holds {} things, which cannot all be the thing '{}': take "
                       "`instances: object`, or leave out `thing`",
                       name, objects, thing);
    }
    const auto [entry, isNew] = things_.emplace(thing, id);
    id = entry->second;
    if (!isNew) objects = 0;
  }
  const Affine start = movement == nullptr ? worldFromMesh : toAffine(movement->at(0)) * worldFromMesh;
  scene_.instances.push_back({mesh, start, id, std::move(name), std::move(movement), std::move(animation)});
  nextInstanceId_ += objects;
  return scene_.instances.back();
}

void SceneBuilder::countRule(const RuleUse& use) {
  const auto key = [](const RuleUse& u) { return std::tie(u.where.file, u.where.line, u.where.column); };
  const auto sum = std::ranges::lower_bound(scene_.rules, key(use), {}, key);
  if (sum == scene_.rules.end() || key(*sum) != key(use)) {
    scene_.rules.insert(sum, use);
    return;
  }
  sum->matched += use.matched;
  sum->decided += use.decided;
}

Scene SceneBuilder::finish() {
  if (scene_.placedTriangles() == 0) {
    throw InputError(
        fmt::format("scene '{}' has no triangle ({} were dropped as broken)", scene_.name, scene_.dropped.total()));
  }
  return std::move(scene_);
}

}  // namespace scanmill
