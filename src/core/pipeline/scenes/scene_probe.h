#pragma once

// Asks a scene what rays meet, before anything is scanned: for ways, heights of the ground, and checks.

#include <memory>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "methods/method.h"
#include "scene/scene.h"

namespace scanmill {

class SceneProbe {
 public:
  struct Ray {
    Vec3d from, direction;  // m; a unit vector
  };
  struct Met {
    double distance = 0;  // m
    Vec3d place;          // m, world
    Vec3d normal;         // unit, towards the ray's start
    std::uint16_t semantic = 0;
    std::uint32_t instance = 0;
  };

  // By `method` where that is exact, else by one that is, which it makes. The scene, as it is at the time 0, and the
  // method must outlive it.
  explicit SceneProbe(const Scene& scene, const Method* method = nullptr, const MethodEntry* entry = nullptr);

  const Scene& scene() const { return scene_; }
  // The first that each ray meets within `reach` m. Faster than ray by ray.
  std::vector<std::optional<Met>> first(const std::vector<Ray>& rays, double reach) const;
  std::optional<Met> first(const Ray& ray, double reach) const { return first(std::vector{ray}, reach).front(); }
  // All that a ray meets one behind the other, a hundred at most.
  std::vector<Met> all(const Ray& ray, double reach) const;

 private:
  const Scene& scene_;
  std::unique_ptr<Method> own_;
  const Method* method_;
};

}  // namespace scanmill
