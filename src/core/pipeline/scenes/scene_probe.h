#pragma once

// Traces single rays in a scene before it is scanned: to find paths and ground heights, and for checks.

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

  // Traces with `method` if `entry` says that it is exact, else with a reference method that the probe creates. Objects
  // are where they are at the time 0. The scene and the method must outlive the probe.
  explicit SceneProbe(const Scene& scene, const Method* method = nullptr, const MethodEntry* entry = nullptr);

  const Scene& scene() const { return scene_; }
  // Returns the first hit of each ray within `reach` m. Faster than a call for each ray.
  std::vector<std::optional<Met>> first(const std::vector<Ray>& rays, double reach) const;
  std::optional<Met> first(const Ray& ray, double reach) const { return first(std::vector{ray}, reach).front(); }
  // Returns all hits along a ray, the nearest first, a hundred at most.
  std::vector<Met> all(const Ray& ray, double reach) const;

 private:
  const Scene& scene_;
  std::unique_ptr<Method> own_;
  const Method* method_;
};

}  // namespace scanmill
