#pragma once

// Places the copies of an object in a scene: listed one by one, on a grid, scattered over surfaces or along a path.
// Copies can vary at random, and stand on the ground.

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scene/ontology.h"
#include "scene/road_path.h"
#include "scene/surface_heights.h"
#include "scenefile/labelling.h"
#include "scenefile/rules.h"

namespace scanmill {

// The pose of `object` defines the object's frame. A copy's position in this frame is the position of its grid cell
// plus the copy's own position in `at`; the copy's scale is multiplied by the object's. Scales act only on the
// geometry, not on the distances between copies. The grid is not centred: its first cell is at the object's position.
// Copies are ordered by grid cell (x fastest, then y, then z), and within each cell as in `at`.
struct Placement {
  struct Copy {
    Pose pose;
    Vec3d scale{1, 1, 1};
  };
  Copy object;
  std::vector<Copy> at{Copy{}};  // the copies of each grid cell
  std::array<std::int64_t, 3> gridCount{1, 1, 1};
  Vec3d gridSpacing;

  // Returns how many copies a scene may have: ten million, or fewer if they would take more than half of the memory
  // limit (base/memory.h).
  static std::uint64_t mostCopies();
  // Returns the end of an error message about too many copies: "at most 10,000,000 are possible".
  static std::string mostCopiesText();

  // Returns the number of copies; 1 if the object has no key `copies`.
  std::uint64_t count() const;
  // Calls visit(worldFromMesh) for each copy, in order.
  void forEach(const std::function<void(const Affine&)>& visit) const;
};

// Reads `position`, the keys of rotations, `scale`, `copies.at` and `copies.grid` from an object's map (docs/keys.md).
// Throws InputError with the place. For more than mostCopies() copies, the message shows their number as a product:
// cells of the grid times positions in `at`.
Placement readPlacement(Fields& object);

// Reads [[x, y], [x, y]], two corners of a rectangle; returns the least x and y, then the greatest. Throws InputError.
std::array<double, 4> readRectangle(const Value& value, std::string_view key);

// Generates the places of an object: scattered over surfaces, with random yaws, or along a path, with the path's
// heading. Each place gets all copies of the object's Placement. The key `vary` rotates a copy about the vertical axis
// through the copy's own position. Random numbers depend only on the scene's seed and the object's name (or its
// `thing`). docs/keys.md lists the keys.
class Arrangement {
 public:
  // Values of an object's keys; each struct is one key.
  struct Distance {
    std::uint16_t semantic = 0;
    double least = 0;                                       // m, as seen from above
    double most = std::numeric_limits<double>::infinity();  // m, as seen from above
    Location where;
  };
  struct Scatter {
    std::vector<std::uint16_t> classes;
    std::vector<Distance> distances;
    std::optional<std::uint64_t> count;
    double density = 0;                           // places per m^2, as seen from above
    double spacing = 0;                           // m, least distance between places, as seen from above
    double slope = 0;                             // rad, largest slope of a surface that gets copies
    std::optional<std::array<double, 4>> within;  // m, least x and y, then the greatest
    bool covered = false;                         // true: surfaces below other surfaces get copies too
    Location where;
  };
  struct Along {
    std::vector<Vec3d> waypoints;  // empty if there is a `trip`
    std::optional<RoadTrip> trip;
    double interval = 0;    // m, distance between places along the path
    double leftOffset = 0;  // m, distance of the places from the path, to its left
    Location where;
  };
  struct Vary {
    Range yaw{0, 0}, scale{1, 1};  // ranges of a copy's random yaw (rad) and scale
    double position = 0;           // m, largest horizontal displacement of a copy
    double presence = 1;           // probability that a copy is present
  };
  struct StandOn {
    std::vector<std::uint16_t> classes;  // classes to stand on; empty: all classes that are not thing classes
    Location where;
  };

  // Reads `copies.scatter`, `copies.along`, `vary` and `stand_on`. Throws InputError with the place.
  Arrangement(Fields& object, const Ontology& ontology);

  bool random() const { return scatter_ || vary_; }
  // Returns the materials from which each copy gets one at random; if empty, every copy keeps the object's material.
  const std::vector<std::string>& materials() const { return materials_; }
  bool needsSurfaces() const { return scatter_ || standOn_ || (along_ && along_->trip); }

  struct Copy {
    Affine worldFromMesh;
    std::size_t variant = 0;  // index of the copy's file and material, below `variants`
    std::size_t number = 1;   // counts all copies from 1, including those that are left out
  };

  // Returns the copies at all places. `vary` moves copies and leaves some out; then each copy is set on a surface of
  // `stand_on`, or left out if no such surface is below or above it. `Copy::variant` is random. `heights`: the surfaces
  // of `scene`, which has the objects listed before this one; required if needsSurfaces(). `lowestZ` returns the z of a
  // copy's lowest point (m, world frame). Throws InputError if the scene has no surface of the required classes, or too
  // little room.
  std::vector<Copy> copies(const Placement& placement, const Scene& scene, const SurfaceHeights* heights,
                           std::uint64_t seed, std::uint32_t object, std::size_t variants,
                           const std::function<double(const Copy&)>& lowestZ) const;

 private:
  std::optional<Scatter> scatter_;
  std::optional<Along> along_;
  std::optional<Vary> vary_;
  std::vector<std::string> materials_;
  std::optional<StandOn> standOn_;
};

// How the copies of an object are placed, and how they move.
struct Copies {
  Placement placement;
  Arrangement arrangement;
  // The n-th copies of all objects with the same `thing` are one thing. If `thing` is empty, each copy is a thing.
  std::string thing;
  // Each copy is placed once for each of these movements; empty: it is placed once and stands still.
  std::vector<std::shared_ptr<const Movement>> movements = {};
  std::shared_ptr<const Animation> animation = nullptr;  // null: the object keeps its mesh
  std::optional<double> facing = {};  // rad, direction in which the object faces, see Instance::facing
};

// The sets of meshes of an object; each copy gets one of the sets at random.
struct Variants {
  std::size_t count = 1;
  // Returns the set of meshes with this index, which is less than `count`. Called once for each index in use; the
  // result must stay valid until all copies are placed.
  std::function<const std::vector<PlacedMesh>&(std::size_t)> meshes;
};

class ObjectPlacer {
 public:
  ObjectPlacer(SceneBuilder& builder, std::uint64_t seed) : builder_(builder), seed_(seed) {}

  // Reads the keys of an object's map that place its copies. Throws InputError with the location in the file.
  Copies read(Fields& object);

  // True if the number, the poses, the files or the materials of the copies placed so far depend on the seed.
  bool random() const { return random_; }

  // Places all copies, in order, each once for each of its movements. Throws InputError; the error's location is
  // `where` if the scene would have more than mostCopies() placed meshes.
  void place(const Variants& variants, const std::string& name, const Copies& copies, const Location& where);
  // Places the copies of an object that has a single mesh.
  void place(std::uint32_t mesh, const std::string& name, const Copies& copies, const Location& where);

 private:
  const SurfaceHeights& surfaces();
  std::vector<std::shared_ptr<const Movement>> movementsOf(const Value& moving);
  double lowestZ(const std::vector<PlacedMesh>& meshes, const Affine& worldFromAsset) const;

  SceneBuilder& builder_;
  std::uint64_t seed_;
  std::optional<SurfaceHeights> heights_;
  std::uint64_t placedMeshes_ = 0;
  bool random_ = false;
  std::map<std::string, std::uint32_t> objectsByName_;  // by name: number of objects so far
};

}  // namespace scanmill
