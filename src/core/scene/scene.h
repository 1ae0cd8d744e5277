#pragma once

// A scene in memory: meshes that instances share, materials, and labels. Methods read it and never change it.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "config/distribution.h"
#include "config/value.h"
#include "scene/material.h"
#include "scene/movement.h"
#include "scene/ontology.h"
#include "scene/shares.h"

namespace scanmill {

// What a triangle belongs to: class, material and thing. The triangles of a mesh share a few surfaces.
struct Surface {
  std::uint16_t material = 0;  // index into Scene::materials
  std::uint16_t semantic = 0;  // class id
  std::uint32_t object = 0;    // 0: stuff; n > 0: the n-th thing of this mesh (see Instance::firstInstanceId)
  // For reports: names in the asset, and the rule of the scene's file, or the key `class`, that gave the class; no file
  // where none did.
  std::string node, texture;
  Location labelledBy;
};

using Triangle = std::array<std::uint32_t, 3>;

// Triangles in the frame of an asset or a primitive, in metres, z up. Every index is in range, every vertex is finite,
// and no triangle has zero area: whoever makes a mesh calls clean().
struct Mesh {
  std::string name;
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;  // empty, or one per position
  std::vector<Triangle> triangles;
  std::vector<std::uint16_t> surfaceOf;  // per triangle: index into surfaces
  std::vector<Surface> surfaces;
  std::uint32_t objects = 0;  // how many things the mesh holds

  Box bounds() const;
};

// How many triangles clean() has dropped, by the reason.
struct Dropped {
  std::uint64_t nonFinite = 0;   // a vertex was NaN or infinite
  std::uint64_t degenerate = 0;  // zero area, or a corner named twice
  std::uint64_t outOfRange = 0;  // an index beyond the vertices
  std::uint64_t total() const { return nonFinite + degenerate + outOfRange; }
  Dropped& operator+=(const Dropped& o);
};

// Drops triangles that cannot be traced, and sets vertices that are not finite to zero. The other triangles keep their
// order.
Dropped clean(Mesh& mesh);

// Meshes of one object that take turns, such as the moments of a stride: each is what it looks like at the start of its
// share of the period, and stands for the time about that. They have the same things.
struct Animation {
  std::vector<std::uint32_t> meshes;
  double period = 1;  // s, in which each shows once
  double until = 0;   // s, when it ends

  std::uint32_t at(double time) const;
};

// A mesh placed in the world.
struct Instance {
  std::uint32_t mesh = 0;
  Affine worldFromMesh;               // at the time 0; determinant is not zero; negative (mirrored) is allowed
  std::uint32_t firstInstanceId = 0;  // object n of the mesh has the id firstInstanceId + n - 1
  std::string name;
  std::shared_ptr<const Movement> movement = nullptr;    // null: it stands still
  std::shared_ptr<const Animation> animation = nullptr;  // null: it keeps its mesh
  // The way that its things face (rad, from the mesh's x towards its y); none: along x, if it is one thing.
  std::optional<double> facing = {};

  bool moves() const { return movement != nullptr || animation != nullptr; }
  // Where it is at a time (s since the drive began); worldFromMesh is where it is at 0.
  Affine worldFromMeshAt(double time) const;
  std::uint32_t meshAt(double time) const { return animation == nullptr ? mesh : animation->at(time); }
};

// Names in an asset of what no rule gives a class.
struct UnlabeledPart {
  std::string file, material, texture, node;
  bool operator==(const UnlabeledPart&) const = default;
  bool operator<(const UnlabeledPart& o) const {
    return std::tie(file, material, texture, node) < std::tie(o.file, o.material, o.texture, o.node);
  }
};

// What came of a rule of the scene's file, in triangles of meshes.
struct RuleUse {
  Location where;
  std::string match, gives;   // in words
  std::uint64_t matched = 0;  // whatever other rules do
  std::uint64_t decided = 0;  // to which it gave a class or a material, or which it dropped
};

// Of a scene that things were taken out of (scene/without.h), what it was with them. How it is traced follows from
// this, so that all other hits stay what they were to the last bit.
struct WholeScene {
  Box bounds;  // m, in the world's frame at the time 0
  bool moves = false;
  std::uint64_t placedTriangles = 0;
  std::vector<std::uint64_t> copies;  // of each mesh: how many instances place it
  std::vector<std::string> absent;    // classes that were to be taken out, of which it has nothing
};

struct Scene {
  std::string name;
  std::uint64_t seed = 0;
  std::filesystem::path file;
  bool procedural = false;         // some of it depends on the seed
  std::string about;               // what kind of place the seed has drawn, in words; empty where none has
  std::vector<DrawnValue> draws;   // what the seed has drawn for keys of its file
  std::vector<ShareBound> shares;  // that its town asks for
  Ontology ontology;
  std::vector<Material> materials;  // index 0 is the default material
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  Dropped dropped;
  std::map<UnlabeledPart, std::uint64_t> unlabeled;  // triangles to which no rule gives a class
  std::vector<RuleUse> rules;                        // in the order of their places
  std::shared_ptr<const WholeScene> whole;           // null: nothing was taken out of it

  bool moves() const;                         // some instance does
  std::uint64_t triangles() const;            // of the meshes, each counted once
  std::uint64_t placedTriangles() const;      // of the instances
  std::uint32_t things() const;               // how many instance ids are given
  Box bounds() const;                         // in the world's frame at the time 0, m; of the whole scene
  std::vector<std::uint64_t> copies() const;  // of each mesh: how many instances place it
};

// The instance id of an object (see Surface::object) of a mesh that is placed with this first id. Stuff has the id 0.
inline std::uint32_t instanceId(std::uint32_t firstInstanceId, std::uint32_t object) {
  return object == 0 ? 0 : firstInstanceId + object - 1;
}

// The instance id of a surface of a placed mesh. Stuff has the id 0.
inline std::uint32_t instanceId(const Instance& instance, const Surface& surface) {
  return instanceId(instance.firstInstanceId, surface.object);
}

// Leaves every object where it is at a time (s since the drive began).
void standStill(Scene& scene, double time);

}  // namespace scanmill
