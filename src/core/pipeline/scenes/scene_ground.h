#pragma once

// Finds the ground of a scene: the surfaces on which vehicles can stand.

#include <vector>

#include "pipeline/scenes/scene_probe.h"
#include "sensors/ground_profile.h"

namespace scanmill {

// The surfaces of a scene that count as ground: those of the given classes, no steeper than 60 degrees. If no class is
// given, surfaces of all classes count except those of object instances such as cars.
class SceneGround : public Ground {
 public:
  // `probe` must outlive this object.
  SceneGround(const SceneProbe& probe, std::vector<std::uint16_t> classes);

  std::optional<double> under(const Vec3d& place) const override;
  std::optional<double> near(const Vec3d& place) const override;

 private:
  bool holds(const SceneProbe::Met& met) const;

  const SceneProbe& probe_;
  std::vector<std::uint16_t> classes_;
  Box bounds_;
};

}  // namespace scanmill
