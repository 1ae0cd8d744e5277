#include "scene/without.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>

#include "base/error.h"
#include "config/fields.h"

namespace scanmill {
namespace {

// Drops triangles of a mesh. The others keep their order.
void drop(Mesh& mesh, const std::function<bool(const Surface&)>& goes) {
  std::vector<bool> leaves(mesh.surfaces.size());
  for (std::size_t s = 0; s < leaves.size(); ++s) leaves[s] = goes(mesh.surfaces[s]);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (leaves[mesh.surfaceOf[t]]) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    mesh.surfaceOf[kept] = mesh.surfaceOf[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  mesh.surfaceOf.resize(kept);
}

bool holds(const Mesh& mesh, std::uint32_t object) {
  return std::any_of(mesh.surfaceOf.begin(), mesh.surfaceOf.end(),
                     [&](std::uint16_t s) { return mesh.surfaces[s].object == object; });
}

// Of the instances that have a part of the thing: their meshes, which others may share, are copied without it.
bool takeOutThing(Scene& scene, std::uint32_t id) {
  bool found = false;
  const auto less = [&](std::uint32_t mesh, std::uint32_t object) {
    Mesh rest = scene.meshes[mesh];
    drop(rest, [&](const Surface& surface) { return surface.object == object; });
    scene.meshes.push_back(std::move(rest));
    return static_cast<std::uint32_t>(scene.meshes.size() - 1);
  };
  for (Instance& instance : scene.instances) {
    const std::uint32_t objects = scene.meshes[instance.mesh].objects;
    if (id < instance.firstInstanceId || id - instance.firstInstanceId >= objects) continue;
    const std::uint32_t object = id - instance.firstInstanceId + 1;
    if (instance.animation != nullptr) {
      auto rest = std::make_shared<Animation>(*instance.animation);
      for (std::uint32_t& mesh : rest->meshes) {
        found = found || holds(scene.meshes[mesh], object);
        mesh = less(mesh, object);
      }
      instance.mesh = rest->meshes.front();
      instance.animation = std::move(rest);
    } else if (holds(scene.meshes[instance.mesh], object)) {
      found = true;
      instance.mesh = less(instance.mesh, object);
    }
  }
  return found;
}

bool isEmpty(const Scene& scene, const Instance& instance) {
  const auto empty = [&](std::uint32_t mesh) { return scene.meshes[mesh].triangles.empty(); };
  if (instance.animation == nullptr) return empty(instance.mesh);
  return std::all_of(instance.animation->meshes.begin(), instance.animation->meshes.end(), empty);
}

// Copies of an object are called NAME#1, NAME#2 and so on.
std::string objectOf(const Instance& instance) {
  return instance.name.substr(0, instance.name.find('#'));
}

bool takeOutNamed(Scene& scene, const std::string& name) {
  return std::erase_if(scene.instances, [&](const Instance& i) { return i.name == name || objectOf(i) == name; }) > 0;
}

}  // namespace

void takeOut(Scene& scene, const std::vector<Value>& what) {
  if (what.empty()) return;
  std::set<std::string> names;
  for (const Instance& instance : scene.instances) names.insert(objectOf(instance));
  for (const Value& item : what) {
    const bool number = !item.quoted && !item.text.empty() &&
                        item.text.find_first_not_of("0123456789") == std::string::npos && item.text.size() < 10;
    if (number) {
      if (takeOutThing(scene, static_cast<std::uint32_t>(std::stoul(item.text)))) continue;
      throw InputError(item.where,
                       fmt::format("without: no thing of the scene '{}' with the seed {} has the instance id {}",
                                   scene.name, scene.seed, item.text));
    }
    const SemanticClass* semantic = scene.ontology.find(item.text);
    if (semantic != nullptr) {
      for (Mesh& mesh : scene.meshes) {
        drop(mesh, [&](const Surface& surface) { return surface.semantic == semantic->id; });
      }
    }
    if (takeOutNamed(scene, item.text) || semantic != nullptr) continue;
    std::vector<std::string> known(names.begin(), names.end());
    for (const SemanticClass& c : scene.ontology.classes) known.push_back(c.name);
    throw InputError(item.where, fmt::format("without: '{}' is neither a class of the ontology '{}' nor the name of an "
                                             "object of the scene '{}'{}",
                                             item.text, scene.ontology.name, scene.name, suggestion(item.text, known)));
  }
  std::erase_if(scene.instances, [&](const Instance& instance) { return isEmpty(scene, instance); });
}

}  // namespace scanmill
