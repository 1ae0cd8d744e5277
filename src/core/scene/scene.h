#pragma once

// A scene in memory: meshes that instances share, materials, and labels. Methods read it and never change it.
//
//   for (const Instance& instance : scene.instances) {
//     std::printf("%s: %zu triangles\n", instance.name.c_str(), scene.meshes[instance.mesh].triangles.size());
//   }

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "config/distribution.h"
#include "config/value.h"
#include "scene/material.h"
#include "scene/ontology.h"

namespace scanmill {

class Path;

// The class, the material and the thing of a triangle. The triangles of a mesh share a few surfaces.
struct Surface {
  std::uint16_t material = 0;  // index into Scene::materials
  std::uint16_t semantic = 0;  // class id
  std::uint32_t object = 0;    // 0: stuff; n > 0: the n-th thing of this mesh (see Instance::firstInstanceId)
  // For reports: `node` and `texture` are names in the asset. `labelledBy` is the place in the scene file of the rule
  // or the key `class` that gave the class; it has no file if the class comes from neither.
  std::string node{}, texture{};
  Location labelledBy{};
};

using Triangle = std::array<std::uint32_t, 3>;

// Triangles in the frame of an asset or a primitive (m, z up). Code that builds a mesh calls clean(), so that every
// index is in range, every vertex is finite, and no triangle has zero area.
struct Mesh {
  std::string name;
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;  // empty, or one per position
  std::vector<Triangle> triangles;
  std::vector<std::uint16_t> surfaceOf;  // index into `surfaces`, by triangle
  std::vector<Surface> surfaces;
  std::uint32_t objects = 0;  // number of things in the mesh

  Box bounds() const;
};

// Numbers of triangles that clean() has dropped, by reason.
struct Dropped {
  std::uint64_t nonFinite = 0;   // triangles with a vertex that was NaN or infinite
  std::uint64_t degenerate = 0;  // triangles with zero area, for example with a repeated corner
  std::uint64_t outOfRange = 0;  // triangles with an index that was not below the number of vertices
  std::uint64_t total() const { return nonFinite + degenerate + outOfRange; }
  Dropped& operator+=(const Dropped& o);
};

// Drops triangles that cannot be traced and returns their numbers; the other triangles keep their order. Sets vertices
// that are not finite to zero.
[[nodiscard]] Dropped clean(Mesh& mesh);

inline constexpr double kFastestObject = 300;  // m/s, largest speed of an object

// The rigid motion of an object over the time of a drive.
class Movement {
 public:
  // Moves in a straight line at this velocity (m/s, world axes), without turning.
  explicit Movement(const Vec3d& velocity);
  // Moves along a path at a constant speed (m/s), from the distance `start` (m) to the path's end, and stops there.
  Movement(std::shared_ptr<const Path> path, double start, double speed);
  // Moves along a path. `travelled` has the distances along the path (m) at the times 0, interval, 2 interval, ... (s);
  // distances between these times are interpolated linearly. The object stops at the last distance.
  Movement(std::shared_ptr<const Path> path, std::vector<double> travelled, double interval);

  // Returns the pose of the object in the world at a time (s since the drive began; earlier times count as 0). In its
  // own frame the object is at the origin and faces along x.
  Pose at(double time) const;
  // True if the pose ever changes.
  bool moves() const;

 private:
  Vec3d velocity_;                    // m/s; only without a path
  std::shared_ptr<const Path> path_;  // null: the object moves in a straight line
  std::vector<double> travelled_;     // m, distances along the path at the times 0, interval_, 2 interval_, ...
  double interval_ = 1;               // s
};

// Meshes of one object that are shown in turn, such as the phases of a stride. Mesh k of n has the object's shape at
// the time k/n * `period`, and is shown while this is the nearest of the n times. All meshes have the same things.
struct Animation {
  std::vector<std::uint32_t> meshes;
  double period = 1;  // s, time in which all meshes are shown once
  double until = 0;   // s, time at which the animation stops

  // Returns the mesh shown at a time (s since the drive began; earlier times count as 0).
  std::uint32_t at(double time) const;
};

// A mesh placed in the world.
struct Instance {
  std::uint32_t mesh = 0;
  Affine worldFromMesh;               // transform at time 0; mirrored if the determinant is negative; not singular
  std::uint32_t firstInstanceId = 0;  // thing n of the mesh has the id firstInstanceId + n - 1
  std::string name;
  std::shared_ptr<const Movement> movement = nullptr;    // null: the instance does not move
  std::shared_ptr<const Animation> animation = nullptr;  // null: the instance always shows the same mesh
  // The direction in which the instance's things face (rad, from the mesh's x axis towards its y axis). If `facing`
  // is not set, the only thing of a mesh faces along the mesh's x axis; one of several things has no known direction.
  std::optional<double> facing = {};

  bool moves() const { return movement != nullptr || animation != nullptr; }
  // True if the instance has an animation, or a movement that ever changes its pose.
  bool everMoves() const { return animation != nullptr || (movement != nullptr && movement->moves()); }
  // Returns the transform at a time (s since the drive began); worldFromMesh is the transform at time 0.
  Affine worldFromMeshAt(double time) const;
  std::uint32_t meshAt(double time) const { return animation == nullptr ? mesh : animation->at(time); }
};

// A part of an asset to which no rule gives a class, identified by names in the asset.
struct UnlabeledPart {
  std::string file, material, texture, node;
  auto operator<=>(const UnlabeledPart&) const = default;  // NOLINT(modernize-use-nullptr): nobody writes one
};

// Numbers of triangles to which a rule of the scene file applied.
struct RuleUse {
  Location where;
  std::string match, gives;   // the conditions and the result of the rule, in words
  std::uint64_t matched = 0;  // number of triangles that satisfy the conditions
  std::uint64_t decided = 0;  // number of triangles that got a class or a material from the rule, or were dropped by it
};

// Properties of a scene before objects were taken out of it (takeOut()). They decide how the remaining scene is
// traced, so that hits on the remaining objects stay the same to the last bit.
struct UnreducedScene {
  Box bounds;  // m, in the world's frame at time 0
  bool moves = false;
  std::uint64_t placedTriangles = 0;
  std::vector<std::uint64_t> copies = {};  // number of instances, by mesh
  std::vector<std::string> absent = {};    // classes to be taken out that had no triangle in the scene
};

// Lanes of a scene's town: points on the road's surface, some metres apart (m, world frame).
struct SceneLanes {
  std::vector<Vec3d> lane;   // along the main road, where the ego vehicle drives
  std::vector<Vec3d> turns;  // like `lane`, but from a side road and into another one, if the town has them
  int turnCount = 0;         // number of turns along `turns`
};

struct Scene {
  std::string name;
  std::uint64_t seed = 0;
  std::filesystem::path file;
  bool procedural = false;        // true: some part of the scene depends on the seed
  std::string about;              // description of a random place; empty if the scene has none
  std::vector<DrawnValue> draws;  // random values of keys of the scene file
  Ontology ontology;
  std::vector<Material> materials;  // index 0 is the default material
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  Dropped dropped;
  std::map<UnlabeledPart, std::uint64_t> unlabeled;  // number of triangles without a class, by part
  std::vector<RuleUse> rules;                        // in the order of their places in files
  std::shared_ptr<const UnreducedScene> unreduced;   // properties before objects were taken out; null: none were
  bool placeable = false;                            // true: shots may place instances elsewhere (Shot::placed)

  bool moves() const;                         // true if an instance moves, or may be placed by shots
  std::uint64_t triangles() const;            // number of triangles of all meshes, each mesh counted once
  std::uint64_t placedTriangles() const;      // number of triangles of all instances
  std::uint32_t things() const;               // largest instance id of the scene's things; 0: it has no things
  Box bounds() const;                         // m, world frame at time 0; if `unreduced` is set, its bounds
  std::vector<std::uint64_t> copies() const;  // number of instances, by mesh
};

// Returns the instance id of the thing `object` (see Surface::object) of an instance; 0 for stuff.
inline std::uint32_t instanceId(std::uint32_t firstInstanceId, std::uint32_t object) {
  return object == 0 ? 0 : firstInstanceId + object - 1;
}

// Returns the instance id of a surface of an instance's mesh; 0 for stuff.
inline std::uint32_t instanceId(const Instance& instance, const Surface& surface) {
  return instanceId(instance.firstInstanceId, surface.object);
}

// Returns an axis-aligned box around a transformed box.
Box boxAround(const Affine& transform, const Box& box);

// Freezes every object in its pose and shape at a time (s since the drive began).
void standStill(Scene& scene, double time);

// Removes objects and classes from the scene. All other things keep their ids, and all other hits stay the same to the
// last bit. `items`: the key `without` of a pipeline's scene. A number removes the thing with this instance id. A word
// removes the objects with this name and all their copies, the copy with this name (NAME#1), and the triangles of the
// class with this name. Throws an InputError at an item that is neither a class of the ontology nor in the scene.
void takeOut(Scene& scene, const std::vector<Value>& items);

// Returns the scene with about the fraction `keep` (above 0, at most 1) of each mesh's triangles, similar to collision
// meshes; 1 gives an unchanged scene. Edges are collapsed first where the shape changes least (quadric error metric;
// Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997). Surfaces keep their
// materials, classes and objects. No triangle crosses from one surface to another, a closed mesh stays closed between
// surfaces, and no surface vanishes, even if that needs more triangles. Meshes of up to 32 triangles stay unchanged.
[[nodiscard]] Scene simplified(const Scene& scene, double keep);

}  // namespace scanmill
