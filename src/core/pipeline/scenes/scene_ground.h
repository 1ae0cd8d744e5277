#pragma once

// The ground of a scene, on which vehicles are placed.

#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"
#include "scene/surface_heights.h"
#include "sensors/ground_profile.h"

namespace scanmill {

// The surfaces of a scene that count as ground: those of the given classes, no steeper than 60 degrees, of objects that
// stand still. If no class is given, surfaces of all classes count except those of object instances such as cars.
class SceneGround : public Ground {
 public:
  // The scene must outlive this object.
  SceneGround(const Scene& scene, std::vector<std::uint16_t> classes);

  std::optional<double> under(const Vec3d& position) const override;
  std::optional<double> near(const Vec3d& position) const override;

 private:
  bool isGround(std::uint16_t semantic) const;

  const Scene& scene_;
  std::vector<std::uint16_t> classes_;
  SurfaceHeights heights_;
};

}  // namespace scanmill
