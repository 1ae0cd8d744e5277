#include "pipeline/scenes/scene_ground.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

SceneGround::SceneGround(const Scene& scene, std::vector<std::uint16_t> classes)
    : scene_(scene), classes_(std::move(classes)), heights_(scene, [this](std::uint16_t id) { return isGround(id); }) {
  heights_.update();
}

bool SceneGround::isGround(std::uint16_t semantic) const {
  if (!classes_.empty()) return std::ranges::find(classes_, semantic) != classes_.end();
  const SemanticClass* const semanticClass = scene_.ontology.find(semantic);
  return semanticClass == nullptr || !semanticClass->thing;
}

std::optional<double> SceneGround::under(const Vec3d& position) const {
  const auto surface = heights_.under(position, [&](const SurfaceHeights::Surface& s) { return isGround(s.semantic); });
  return surface ? std::optional(surface->height) : std::nullopt;
}

std::optional<double> SceneGround::near(const Vec3d& position) const {
  constexpr double kMostDistance = 1.5;  // m, see Ground::near()
  for (const double offset : {0.0, kBesideSeam}) {
    std::optional<double> nearest;
    for (const SurfaceHeights::Surface& s : heights_.at(position.x + offset, position.y + offset)) {
      const double distance = std::fabs(s.height - position.z);
      if (distance > kMostDistance || s.slope > kSteepestGround || !isGround(s.semantic)) continue;
      if (!nearest || distance < std::fabs(*nearest - position.z)) nearest = s.height;
    }
    if (nearest) return nearest;
  }
  return std::nullopt;
}

}  // namespace scanmill
