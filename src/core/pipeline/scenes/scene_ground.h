#pragma once

// Finds the surfaces of a scene on which vehicles stand.

#include <vector>

#include "pipeline/scenes/scene_probe.h"
#include "sensors/ground_profile.h"

namespace scanmill {

// Returns the ids of classes by their names. Throws InputError at `where` for a name that the ontology does not have.
std::vector<std::uint16_t> classIds(const Ontology& ontology, const std::vector<std::string>& names,
                                    const Location& where);

// Surfaces no steeper than 60 degrees, of the given classes; if no class is given, of all that are not thing classes.
class SceneGround : public Ground {
 public:
  // The probe must outlive it.
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
