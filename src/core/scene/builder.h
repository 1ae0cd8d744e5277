#pragma once

// Puts a scene together: finds classes and materials by their names, cleans meshes, gives things their instance ids.

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

  // The index in Scene::materials of a material of the library, which is added at its first use. Throws an InputError
  // at `where`, with a suggestion, for a name that the library does not have.
  std::uint16_t material(std::string_view name, const Location& where);
  // Adds a material of an asset and returns its index in Scene::materials. Materials whose fields are all equal share
  // an index.
  std::uint16_t addMaterial(const Material& material);

  // Makes a surface of a class, by its name or alias, and a material of the library. Surface::object is 1 for a class
  // of things, 0 for one of stuff. Throws an InputError at `where` for an unknown name.
  Surface surface(std::string_view className, std::string_view materialName, const Location& where = {});

  // Keeps a mesh and returns its index in Scene::meshes. Triangles that cannot be traced are dropped and counted;
  // Mesh::objects is set from the surfaces.
  std::uint32_t addMesh(Mesh mesh);

  // Places a mesh in the world (m). Its things get the next instance ids, counted from 1, so that ids follow from the
  // order of placement alone. Throws an InputError at `where` for a transform that is singular or not finite.
  // With a movement `worldFromMesh` is its place relative to that of the movement. What is placed under the same name
  // of a thing is that one thing, with one id; an empty one names none. Throws for a mesh of several things with one.
  // What is returned holds until the next is placed.
  Instance& place(std::uint32_t mesh, const Affine& worldFromMesh, std::string name, const Location& where = {},
                  std::shared_ptr<const Movement> movement = nullptr,
                  std::shared_ptr<const Animation> animation = nullptr, const std::string& thing = {});

  // What has been placed so far.
  const Scene& soFar() const { return scene_; }

  // Counts triangles that were dropped before addMesh() was given their mesh.
  void addDropped(const Dropped& dropped) { scene_.dropped += dropped; }

  // Counts triangles to which no rule gives a class.
  void addUnlabeled(const UnlabeledPart& what, std::uint64_t triangles) { scene_.unlabeled[what] += triangles; }

  // Adds to the counts of the rule at this place in Scene::rules.
  void countRule(const RuleUse& more);

  // What kind of place it is: Scene::about.
  void describe(const std::string& about) { scene_.about = about; }

  // What its town asks for: Scene::shares.
  void ask(std::vector<ShareBound> shares) { scene_.shares = std::move(shares); }

  // Returns the scene. Throws InputError where it has no triangle.
  Scene finish();

 private:
  Scene scene_;
  MaterialLibrary library_;
  std::uint32_t nextInstanceId_ = 1;
  std::map<std::string, std::uint32_t> things_;  // ids of those that have a name
};

}  // namespace scanmill
