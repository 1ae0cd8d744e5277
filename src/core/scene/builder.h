#pragma once

// Builds a scene: finds classes and materials by their names, cleans meshes, and assigns instance ids to things.
//
//   SceneBuilder builder("yard", 1, readOntology("labels/scanmill.yaml"), readMaterials("labels/materials.yaml"));
//   mesh.surfaces = {builder.surface("car", "car_paint")};
//   builder.place(builder.addMesh(mesh), Affine{{}, {10, 2, 0}}, "car");
//   const Scene yard = builder.finish();

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace scanmill {

class SceneBuilder {
 public:
  SceneBuilder(std::string name, std::uint64_t seed, Ontology ontology, MaterialLibrary library);

  const Ontology& ontology() const { return scene_.ontology; }
  const MaterialLibrary& library() const { return library_; }
  // Replaces the reflectance of each material of the library by a random one that depends on the scene's seed: with
  // probability 1/2 from Material::least to the old reflectance, else from the old reflectance to Material::greatest,
  // uniform on a logarithmic scale. Call it once, before anything is added.
  void drawReflectances();

  // Returns the index in Scene::materials of the library's material `name`; adds the material if it is not there yet.
  // Throws an InputError at `where`, with a suggestion, if the library has no such material.
  std::uint16_t material(std::string_view name, const Location& where);
  // Adds a material of an asset and returns its index in Scene::materials. Materials whose fields are all equal share
  // an index.
  std::uint16_t addMaterial(const Material& material);

  // Returns a surface with the class `className` (a name or an alias) and the library's material `materialName`.
  // Surface::object is 1 for a class of things, else 0. Throws an InputError at `where` for an unknown name.
  Surface surface(std::string_view className, std::string_view materialName, const Location& where = {});

  // Adds a mesh and returns its index in Scene::meshes. Triangles that cannot be traced are dropped and counted;
  // Mesh::objects is computed from the surfaces.
  [[nodiscard]] std::uint32_t addMesh(Mesh mesh);

  // Places a mesh in the world frame (m) or, with a `movement`, in the frame of the moving object. The mesh's things
  // get the next instance ids, counted from 1, so that ids depend only on the order of placement. Instances with the
  // same `thing`, unless it is empty, are one thing with one id. Throws an InputError at `where` for a transform that
  // is singular or not finite, and for a mesh of several things that is placed with a `thing`. The returned reference
  // is valid until the next call.
  Instance& place(std::uint32_t mesh, const Affine& worldFromMesh, std::string name, const Location& where = {},
                  std::shared_ptr<const Movement> movement = nullptr,
                  std::shared_ptr<const Animation> animation = nullptr, const std::string& thing = {});

  // Returns the scene as it has been built so far.
  const Scene& soFar() const { return scene_; }

  // Counts triangles that were dropped before their mesh was passed to addMesh().
  void addDropped(const Dropped& dropped) { scene_.dropped += dropped; }

  // Counts triangles to which no rule gives a class.
  void addUnlabeled(const UnlabeledPart& part, std::uint64_t triangles) { scene_.unlabeled[part] += triangles; }

  // Adds the counts in `use` to the entry of Scene::rules with the same RuleUse::where, or adds `use` as a new entry.
  void countRule(const RuleUse& use);

  // Sets Scene::about, the description of a random place.
  void describe(const std::string& about) { scene_.about = about; }

  // Returns the scene. Throws InputError if it has no triangle.
  [[nodiscard]] Scene finish();

 private:
  Scene scene_;
  MaterialLibrary library_;
  std::uint32_t nextInstanceId_ = 1;
  std::map<std::string, std::uint32_t> things_;  // name of a thing -> its instance id
};

}  // namespace scanmill
