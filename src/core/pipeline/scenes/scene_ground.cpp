#include "pipeline/scenes/scene_ground.h"

#include <algorithm>
#include <cmath>

#include "scene/surface_heights.h"

namespace scanmill {
namespace {

constexpr double kNear = 1.5;  // maximum height difference between a place and the ground that near() finds (m)
constexpr Vec3d kDown{0, 0, -1};

}  // namespace

SceneGround::SceneGround(const SceneProbe& probe, std::vector<std::uint16_t> classes)
    : probe_(probe), classes_(std::move(classes)), bounds_(probe.bounds()) {}

bool SceneGround::holds(const SceneProbe::Met& met) const {
  if (std::fabs(met.normal.z) < kSteepestGroundCosine) return false;
  if (!classes_.empty()) return std::find(classes_.begin(), classes_.end(), met.semantic) != classes_.end();
  const SemanticClass* const own = probe_.scene().ontology.find(met.semantic);
  return own == nullptr || !own->thing;
}

std::optional<double> SceneGround::under(const Vec3d& place) const {
  if (bounds_.empty()) return std::nullopt;
  const double top = bounds_.high.z + 1;
  const auto met = probe_.all({{place.x, place.y, top}, kDown}, top - bounds_.low.z + 1);
  const SceneProbe::Met* const found = groundUnder(
      met, place.z, [](const SceneProbe::Met& m) { return m.place.z; },
      [&](const SceneProbe::Met& m) { return holds(m); });
  return found == nullptr ? std::nullopt : std::optional(found->place.z);
}

std::optional<double> SceneGround::near(const Vec3d& place) const {
  std::optional<double> nearest;
  for (const SceneProbe::Met& met : probe_.all({place - kDown * kNear, kDown}, 2 * kNear)) {
    if (holds(met) && (!nearest || std::fabs(met.place.z - place.z) < std::fabs(*nearest - place.z))) {
      nearest = met.place.z;
    }
  }
  return nearest;
}

}  // namespace scanmill
