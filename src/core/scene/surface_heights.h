#pragma once

// Finds the surfaces above and below a point of a scene, while the scene is being built, and horizontal distances of
// points from the surfaces of given classes.

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

constexpr double kAboveGround = 0.5;         // m; ground up to this far above a point still counts as ground under it
constexpr double kSteepestGround = kPi / 3;  // rad, largest slope of ground

// Shift of a second ray (m). A vertical ray exactly on the edge between two meshes may miss both, because of rounding.
// If a ray finds no ground, a second ray is therefore traced, shifted by this distance along x and along y.
constexpr double kBesideSeam = 1e-3;

// Finds surfaces by vertical rays. Each mesh is stored once, even if several instances share it.
class SurfaceHeights {
 public:
  struct Surface {
    double height = 0;  // m, z in the world frame
    double slope = 0;   // rad, 0 is horizontal
    std::uint16_t semantic = 0;
    bool thing = false;
  };
  // A triangle of an instance's mesh.
  struct Facet {
    std::uint32_t instance, triangle;                // indices
    auto operator<=>(const Facet&) const = default;  // NOLINT(modernize-use-nullptr): nobody writes one
  };

  // The scene must outlive this object. The object knows no instance before the first update(). `isNeeded`: false for
  // classes that the caller ignores: meshes with no other classes are left out, which saves time.
  explicit SurfaceHeights(const Scene& scene, std::function<bool(std::uint16_t)> isNeeded = {});
  ~SurfaceHeights();

  // Adds the instances that were added to the scene since the last call, except moving instances.
  void update();

  // Returns all surfaces at a point (m, world frame) except vertical ones, the highest first.
  std::vector<Surface> at(double x, double y) const;
  // Returns the ground under a position: of the surfaces that satisfy `condition` and are at most 60 degrees steep, the
  // highest that is at most kAboveGround above the position, else the lowest; nothing if there is no such surface.
  template <class Condition>
  std::optional<Surface> under(const Vec3d& position, const Condition& condition) const {
    std::optional<Surface> ground;
    for (const double offset : {0.0, kBesideSeam}) {
      for (const Surface& s : at(position.x + offset, position.y + offset)) {
        if (!(s.slope <= kSteepestGround) || !condition(s)) continue;
        ground = s;
        if (s.height <= position.z + kAboveGround) break;
      }
      if (ground) break;
    }
    return ground;
  }

  // The surfaces of given classes that face up, as an area to sample. If no surface faces up, the area has all surfaces
  // of the classes, since files may have flipped triangles. An area is valid until the next update().
  class Area {
   public:
    double squareMetres() const { return sums_.empty() ? 0 : sums_.back(); }  // area as seen from above
    // Samples a point on the surfaces (m, world frame), uniformly by their area as seen from above, which must not be
    // 0. `u`: three random numbers from 0 to 1.
    Vec3d sample(const std::array<double, 3>& u) const;

   private:
    friend class SurfaceHeights;
    const Scene* scene_ = nullptr;
    std::vector<Facet> facets_;
    std::vector<double> sums_;  // m^2, by facet: area of the facets up to this one, as seen from above
  };
  Area area(const std::vector<std::uint16_t>& classes) const;

 private:
  struct Hierarchy;
  const Scene& scene_;
  std::function<bool(std::uint16_t)> isNeeded_;  // empty: all classes are needed
  std::size_t addedInstances_ = 0;               // number of the scene's instances that update() has processed
  std::unique_ptr<Hierarchy> hierarchy_;
};

class SurfaceDistance {
 public:
  // Reads the triangles of these classes from all instances that are already in the scene, except moving instances.
  // Distances beyond `reach` (m) count as infinite.
  SurfaceDistance(const Scene& scene, const std::vector<std::uint16_t>& classes, double reach);

  // Returns the horizontal distance to the nearest triangle (m); 0 above or below a triangle; infinite beyond the
  // reach.
  double at(double x, double y) const;
  bool empty() const { return triangles_.empty(); }

 private:
  // Returns the column and the row of the cell that contains (x, y) (m) or, outside of the grid, of the nearest cell.
  std::array<std::size_t, 2> cellOf(double x, double y) const;

  std::vector<std::array<Vec3d, 3>> triangles_;    // corners (m, world frame); only x and y are used
  std::vector<std::vector<std::uint32_t>> cells_;  // indices of the triangles whose boxes overlap a cell, by cell
  Vec3d low_;                                      // corner of the grid with the least x and y (m)
  double edge_ = 1;                                // m, edge of a cell, at least `reach_`
  double reach_ = 0;                               // m
  std::size_t columns_ = 0, rows_ = 0;             // number of cells along x and y
};

}  // namespace scanmill
