#pragma once

// Puts the copies of an object into a scene.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/fields.h"
#include "scene/builder.h"
#include "scene/surface_heights.h"
#include "scenefile/arrangement.h"
#include "scenefile/labelling.h"
#include "scenefile/placement.h"

namespace scanmill {

// How the copies of an object are placed, and how they move.
struct Copies {
  Placement placement;
  Arrangement arrangement;
  std::string thing;  // the n-th copies of all objects with the same `thing` are one thing; if empty, each copy is a
                      // thing
  // Each copy moves once as each of these movements says; empty: the object stands still.
  std::vector<std::shared_ptr<const Movement>> movements;
  std::shared_ptr<const Animation> animation;  // null: the object keeps its mesh
  std::optional<double> facing = {};           // rad, direction in which the object faces, see Instance::facing
};

// The sets of meshes of an object; each copy gets one of the sets at random.
struct Variants {
  std::size_t count = 1;
  // Returns one of the sets of meshes; the argument is its index, less than `count`. Called once for each index in use;
  // the result must stay valid until all copies are placed.
  std::function<const std::vector<PlacedMesh>&(std::size_t)> meshes;
};

class ObjectPlacer {
 public:
  ObjectPlacer(SceneBuilder& builder, std::uint64_t seed) : builder_(builder), seed_(seed) {}

  // Reads the keys of an object's map that place its copies. Throws InputError with the location in the file.
  Copies read(Fields& object);

  // True if the number, the poses, the files or the materials of the copies placed so far depend on the seed.
  bool random() const { return random_; }

  // Places all copies, in order. Throws InputError, at `where` if the scene then has over mostCopies() placed meshes.
  void place(const Variants& variants, const std::string& name, const Copies& copies, const Location& where);
  // Places the copies of an object that has a single set of meshes.
  void place(const std::vector<PlacedMesh>& meshes, const std::string& name, const Copies& copies,
             const Location& where);

 private:
  using Chosen = std::function<const std::vector<PlacedMesh>&(std::size_t)>;
  const SurfaceHeights& surfaces();
  std::vector<std::shared_ptr<const Movement>> movementsOf(const Value& moving);
  double lowestOf(const std::vector<PlacedMesh>& meshes, const Affine& worldFromAsset) const;
  std::vector<Arrangement::Copy> placesOf(const Copies& copies, const std::string& name, std::size_t variants,
                                          const Chosen& meshesOf);

  SceneBuilder& builder_;
  std::uint64_t seed_;
  std::optional<SurfaceHeights> heights_;
  std::uint64_t placed_ = 0;
  bool random_ = false;
  std::map<std::string, std::uint32_t> named_;  // by name: the number of objects with that name so far
};

}  // namespace scanmill
