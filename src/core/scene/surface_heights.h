#pragma once

// The surfaces of a scene as they are seen from above, while it is being made.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

constexpr double kAboveGround = 0.5;           // m, of ground above a place that is still taken for under it
constexpr double kSteepestGround = kPi / 3;    // rad, of what is stood on
constexpr double kSteepestGroundCosine = 0.5;  // of that

// Of surfaces at one place, the highest first: the highest that is below the height `z`, or not more than kAboveGround
// above; where there is none, the lowest above it; null where there is none at all. `heightOf` tells a surface's
// height, `holds` whether it counts.
template <class Surface, class HeightOf, class Holds>
const Surface* groundUnder(const std::vector<Surface>& surfaces, double z, const HeightOf& heightOf,
                           const Holds& holds) {
  const Surface* lowest = nullptr;
  for (const Surface& s : surfaces) {
    if (!holds(s)) continue;
    lowest = &s;
    if (heightOf(s) <= z + kAboveGround) break;
  }
  return lowest;
}

// Meshes are kept once, however often they are placed.
class SurfaceHeights {
 public:
  struct Surface {
    double height = 0;  // m
    double slope = 0;   // rad, from level
    std::uint16_t semantic = 0;
    bool thing = false;
  };

  // The scene, of which nothing is taken yet, must outlive it.
  explicit SurfaceHeights(const Scene& scene);
  ~SurfaceHeights();

  // Takes what has been placed in the scene since the last call, but for what moves.
  void update();

  // All surfaces at a place, the highest first.
  std::vector<Surface> at(double x, double y) const;
  // That of groundUnder() of which `holds`, and which is not steeper than 60 degrees.
  template <class Holds>
  std::optional<Surface> under(const Vec3d& place, const Holds& holds) const {
    const std::vector<Surface> all = at(place.x, place.y);
    const Surface* const found = groundUnder(
        all, place.z, [](const Surface& s) { return s.height; },
        [&](const Surface& s) { return s.slope <= kSteepestGround && holds(s); });
    return found == nullptr ? std::nullopt : std::optional(*found);
  }

  // The surfaces of certain classes that face up; all of these classes where none does, since files may turn them over.
  // Valid until the next update().
  class Area {
   public:
    double squareMetres() const { return sums_.empty() ? 0 : sums_.back(); }  // as seen from above
    // A place on them, of all as likely; `u`: three numbers from 0 to 1. Wants squareMetres() above 0.
    Vec3d place(const std::array<double, 3>& u) const;

   private:
    friend class SurfaceHeights;
    struct Facet {
      std::uint32_t instance, triangle;
    };
    const Scene* scene_ = nullptr;
    std::vector<Facet> facets_;
    std::vector<double> sums_;
  };
  Area area(const std::vector<std::uint16_t>& classes) const;

 private:
  struct Hierarchy;
  const Scene& scene_;
  std::size_t taken_ = 0;  // instances
  std::unique_ptr<Hierarchy> hierarchy_;
};

}  // namespace scanmill
