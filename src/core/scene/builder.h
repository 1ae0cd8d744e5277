#pragma once

// Puts a scene together: resolves class and material names, cleans meshes, hands out instance ids.

#include <cstdint>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace scanmill {

class SceneBuilder {
 public:
  SceneBuilder(std::string name, std::uint64_t seed, Ontology ontology, MaterialLibrary library);

  const Ontology& ontology() const { return scene_.ontology; }
  const MaterialLibrary& library() const { return library_; }

  // Index in Scene::materials of a material of the library, added at its first use. InputError with a suggestion.
  std::uint16_t material(std::string_view name, const Location& where);
  // Adds a material of an asset; equal ones (all fields) share an index.
  std::uint16_t addMaterial(const Material& material);

  // A surface of a class by name or alias and a material of the library. object is 1 for a thing, 0 for stuff.
  Surface surface(std::string_view className, std::string_view materialName, const Location& where = {});

  // Cleans the mesh, sets Mesh::objects from its surfaces, counts what was dropped, and keeps it. Returns its index.
  std::uint32_t addMesh(Mesh mesh);

  // Places a mesh; its things get the next instance ids (from 1), so ids follow the order of placement alone. A
  // singular or non-finite transform is an InputError at `where`.
  void place(std::uint32_t mesh, const Affine& worldFromMesh, std::string name, const Location& where = {});

  // What was dropped before addMesh() saw it.
  void addDropped(const Dropped& dropped) { scene_.dropped += dropped; }

  void addUnlabeled(const std::string& what, std::uint64_t triangles) { scene_.unlabeled[what] += triangles; }

  // Throws where the scene has no triangle.
  Scene finish();

 private:
  Scene scene_;
  MaterialLibrary library_;
  std::uint32_t nextInstanceId_ = 1;
};

}  // namespace scanmill
