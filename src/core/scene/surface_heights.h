#pragma once

// The surfaces of a scene as they are seen from above, while it is being made.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

class SurfaceHeights {
 public:
  struct Surface {
    double height = 0;  // m
    double slope = 0;   // rad, from level
    std::uint16_t semantic = 0;
    bool thing = false;
  };

  // Of all that has been placed in the scene, but for what moves.
  explicit SurfaceHeights(const Scene& scene);

  // All surfaces at a place, the highest first.
  std::vector<Surface> at(double x, double y) const;
  // The highest of those that `holds` that is below a place, or not more than 0.5 m above; where there is none, the
  // lowest above it.
  template <class Holds>
  std::optional<Surface> under(const Vec3d& place, const Holds& holds) const {
    std::optional<Surface> lowest;
    for (const Surface& s : at(place.x, place.y)) {
      if (!holds(s)) continue;
      lowest = s;
      if (s.height <= place.z + 0.5) break;
    }
    return lowest;
  }

  // A place on a surface of certain classes, of all as likely; `u`: three numbers from 0 to 1. Nothing where no
  // surface is of these classes.
  class Area {
   public:
    double squareMetres() const { return sums_.empty() ? 0 : sums_.back(); }  // as seen from above
    Vec3d place(const std::array<double, 3>& u) const;

   private:
    friend class SurfaceHeights;
    std::vector<std::array<Vec3d, 3>> triangles_;
    std::vector<double> sums_;
  };
  Area area(const std::vector<std::uint16_t>& classes) const;

 private:
  struct Facet {
    std::array<Vec3d, 3> corner;
    std::uint16_t semantic;
    bool thing;
  };
  std::vector<Facet> facets_;
  Box bounds_;
  double cell_ = 1;  // m
  std::size_t across_ = 1, up_ = 1;
  std::vector<std::uint32_t> begin_, inCell_;  // facets by cells
};

}  // namespace scanmill
