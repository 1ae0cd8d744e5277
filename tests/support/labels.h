#pragma once

// The program's own labels, scenes that use them, and what is in a scene.

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "scene/builder.h"

namespace scanmill {

inline const std::filesystem::path kLabels = std::filesystem::path(SCANMILL_SOURCE_DIR) / "labels";

inline SceneBuilder labelledBuilder(std::string name = "test", std::uint64_t seed = 1) {
  return {std::move(name), seed, readOntology(kLabels / "scanmill.yaml"), readMaterials(kLabels / "materials.yaml")};
}

// The text of a scene file. `objects` are the items of its list, which begins in line 4; `more` are other keys.
inline std::string sceneYaml(const std::string& objects, const std::string& more = "") {
  return "ontology: " + (kLabels / "scanmill.yaml").string() + "\nmaterials: " + (kLabels / "materials.yaml").string() +
         "\n" + more + "objects:\n" + objects;
}

// How many placed triangles each class has, by its name.
inline std::map<std::string, std::uint64_t> trianglesByClass(const Scene& scene) {
  std::map<std::string, std::uint64_t> count;
  for (const Instance& i : scene.instances) {
    const Mesh& mesh = scene.meshes[i.mesh];
    std::vector<std::uint64_t> ofSurface(mesh.surfaces.size());
    for (const std::uint16_t s : mesh.surfaceOf) ++ofSurface[s];
    for (std::size_t s = 0; s < ofSurface.size(); ++s) {
      if (ofSurface[s] > 0) count[scene.ontology.find(mesh.surfaces[s].semantic)->name] += ofSurface[s];
    }
  }
  return count;
}

inline std::set<std::string> classesOf(const Scene& scene) {
  std::set<std::string> names;
  for (const auto& [name, triangles] : trianglesByClass(scene)) names.insert(name);
  return names;
}

template <class T>
std::string_view bytesOfItems(const std::vector<T>& v) {
  return {reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T)};
}

inline std::string hash(const Mesh& mesh) {
  Sha256 sha;
  sha.add(bytesOfItems(mesh.positions));
  sha.add(bytesOfItems(mesh.triangles));
  sha.add(bytesOfItems(mesh.surfaceOf));
  return sha.hex();
}

inline std::string hash(const Scene& scene) {
  Sha256 sha;
  for (const Mesh& mesh : scene.meshes) sha.add(hash(mesh));
  for (const Instance& i : scene.instances) {
    sha.add(i.name);
    sha.add({reinterpret_cast<const char*>(&i.worldFromMesh), sizeof(Affine)});
    sha.add({reinterpret_cast<const char*>(&i.mesh), sizeof(i.mesh)});
    sha.add({reinterpret_cast<const char*>(&i.firstInstanceId), sizeof(i.firstInstanceId)});
  }
  return sha.hex();
}

}  // namespace scanmill
