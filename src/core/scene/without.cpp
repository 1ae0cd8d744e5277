// takeOut(): takes objects out of a scene.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "base/error.h"
#include "config/fields.h"
#include "config/text.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

void dropTriangles(Mesh& mesh, const std::function<bool(const Surface&)>& condition) {
  std::vector<bool> isDropped;  // by surface
  for (const Surface& surface : mesh.surfaces) isDropped.push_back(condition(surface));
  keepTriangles(mesh, [&](std::size_t t) { return !isDropped[mesh.surfaceOf[t]]; });
}

bool hasObject(const Mesh& mesh, std::uint32_t object) {
  return std::ranges::any_of(mesh.surfaceOf, [&](std::uint16_t s) { return mesh.surfaces[s].object == object; });
}

// Takes a thing out of the scene; returns false if the scene does not have it. Every instance with a part of the thing
// gets a copy of its mesh without that part, since other instances may share the mesh. UnreducedScene::copies gets an
// entry for each of these meshes.
bool takeOutThing(Scene& scene, std::uint32_t id, UnreducedScene& unreduced) {
  bool hasThing = false;
  const auto addMeshWithout = [&](std::uint32_t mesh, std::uint32_t object) {
    Mesh reduced = scene.meshes[mesh];
    dropTriangles(reduced, [&](const Surface& surface) { return surface.object == object; });
    scene.meshes.push_back(std::move(reduced));
    unreduced.copies.push_back(unreduced.copies[mesh]);
    return static_cast<std::uint32_t>(scene.meshes.size() - 1);
  };
  for (Instance& instance : scene.instances) {
    const std::uint32_t objects = scene.meshes[instance.mesh].objects;
    if (id < instance.firstInstanceId || id - instance.firstInstanceId >= objects) continue;
    const std::uint32_t object = id - instance.firstInstanceId + 1;
    if (instance.animation != nullptr) {
      auto reduced = std::make_shared<Animation>(*instance.animation);
      for (std::uint32_t& mesh : reduced->meshes) {
        hasThing = hasThing || hasObject(scene.meshes[mesh], object);
        mesh = addMeshWithout(mesh, object);
      }
      instance.mesh = reduced->meshes.front();
      instance.animation = std::move(reduced);
    } else if (hasObject(scene.meshes[instance.mesh], object)) {
      hasThing = true;
      instance.mesh = addMeshWithout(instance.mesh, object);
    }
  }
  return hasThing;
}

bool isEmpty(const Scene& scene, const Instance& instance) {
  const auto empty = [&](std::uint32_t mesh) { return scene.meshes[mesh].triangles.empty(); };
  if (instance.animation == nullptr) return empty(instance.mesh);
  return std::ranges::all_of(instance.animation->meshes, empty);
}

// Returns true if an instance belongs to the object or copy called `name`. Copies of an object are called NAME#1,
// NAME#2 and so on; meshes that the object's file places several times are called NAME/NODE 1 or NAME#1/NODE 1.
bool belongsTo(const Instance& instance, const std::string& name) {
  if (!instance.name.starts_with(name)) return false;
  const std::string_view suffix = std::string_view(instance.name).substr(name.size());
  if (suffix.empty() || suffix.front() == '#') return true;
  const std::size_t blank = suffix.rfind(' ');
  return suffix.front() == '/' && blank != std::string_view::npos && blank + 1 < suffix.size() &&
         suffix.find_first_not_of("0123456789", blank + 1) == std::string_view::npos;
}

// Returns the instance id if the item is a whole number without quotes, else nullopt.
std::optional<std::uint32_t> idOf(const Value& item) {
  const bool digits = !item.text.empty() && item.text.find_first_not_of("0123456789") == std::string::npos;
  if (item.quoted || !digits || item.text.size() > 9) return {};
  return static_cast<std::uint32_t>(std::stoul(item.text));
}

// Throws InputError for an item that names nothing in the scene, with a suggestion.
[[noreturn]] void refuse(const Scene& scene, const Value& item) {
  std::set<std::string> names;  // names of objects, without the numbers of copies, and of classes
  for (const Instance& instance : scene.instances) names.insert(instance.name.substr(0, instance.name.find('#')));
  for (const SemanticClass& c : scene.ontology.classes) names.insert(c.name);
  const std::string nearestName = nearest(item.text, {names.begin(), names.end()});
  const std::string hint = nearestName.empty() ? "; names and ids stand in the objects of samples (output.objects)"
                                               : fmt::format(" (did you mean '{}'?)", nearestName);
  throw InputError(item.where,
                   "without: {} is neither a class of the ontology '{}' nor the name of an object of the scene '{}'{}",
                   quotedForMessage(item.text), scene.ontology.name, scene.name, hint);
}

}  // namespace

void takeOut(Scene& scene, const std::vector<Value>& items) {
  if (items.empty()) return;
  UnreducedScene unreduced{.bounds = scene.bounds(),
                           .moves = scene.moves(),
                           .placedTriangles = scene.placedTriangles(),
                           .copies = scene.copies()};
  if (scene.unreduced != nullptr) unreduced = *scene.unreduced;
  for (const Value& item : items) {
    if (const std::optional<std::uint32_t> id = idOf(item)) {
      if (takeOutThing(scene, *id, unreduced)) continue;
      throw InputError(item.where, "without: no thing of the scene '{}' with the seed {} has the instance id {}",
                       scene.name, scene.seed, item.text);
    }
    std::size_t droppedTriangles = 0;
    const SemanticClass* semantic = scene.ontology.find(item.text);
    if (semantic != nullptr) {
      for (Mesh& mesh : scene.meshes) {
        const std::size_t triangleCount = mesh.triangles.size();
        dropTriangles(mesh, [&](const Surface& surface) { return surface.semantic == semantic->id; });
        droppedTriangles += triangleCount - mesh.triangles.size();
      }
    }
    const bool hasNamed =
        std::erase_if(scene.instances, [&](const Instance& instance) { return belongsTo(instance, item.text); }) > 0;
    if (semantic == nullptr && !hasNamed) refuse(scene, item);
    if (!hasNamed && droppedTriangles == 0) unreduced.absent.push_back(item.text);
  }
  std::erase_if(scene.instances, [&](const Instance& instance) { return isEmpty(scene, instance); });
  scene.unreduced = std::make_shared<const UnreducedScene>(std::move(unreduced));
}

}  // namespace scanmill
