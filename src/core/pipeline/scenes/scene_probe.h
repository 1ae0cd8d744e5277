#pragma once

// Traces single rays in a scene before it is scanned. Checks use these rays, and so does findRandomPath(), which finds
// paths on which vehicles can drive. Also finds the ground of a scene, on which vehicles are placed.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "methods/method.h"
#include "scene/scene.h"
#include "scene/surface_heights.h"
#include "sensors/ground_profile.h"
#include "sensors/trajectory.h"

namespace scanmill {

class SceneProbe {
 public:
  struct Ray {
    Vec3d from, direction;  // start in the world frame (m); unit vector
  };
  struct Hit {
    double distance = 0;  // distance from the start of the ray (m)
    Vec3d position;       // m, world frame
    Vec3d normal;         // unit vector, on the side of the surface from which the ray comes
    std::uint16_t semantic = 0;
    std::uint32_t instance = 0;
  };

  // Traces rays with `method` if `entry` says that it is exact, otherwise with a reference method that this object
  // creates. Objects are at their positions at time 0 s. The scene and the method must outlive this object.
  explicit SceneProbe(const Scene& scene, const Method* method = nullptr, const MethodEntry* entry = nullptr);

  const Scene& scene() const { return scene_; }
  const Box& bounds() const { return bounds_; }  // Scene::bounds(): m, world frame at time 0
  // Returns the first hit of each ray within `reach` (m); nothing for rays without a hit. Faster than calls for single
  // rays. The rays must start near each other.
  std::vector<std::optional<Hit>> first(const std::vector<Ray>& rays, double reach) const;
  std::optional<Hit> first(const Ray& ray, double reach) const { return first(std::vector{ray}, reach).front(); }

 private:
  // Returns the distance (m) along a ray beyond which it does not hit the scene; may be negative.
  double endOf(const Ray& ray) const;

  const Scene& scene_;
  Box bounds_;
  std::unique_ptr<Method> own_;  // null: the constructor's method is used
  const Method* method_;
};

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

// Returns the points (m, world frame) of a random path on surfaces of the classes in `request`, about 4 m apart. The
// path has the requested length, rounded up to arcs of 4 m, and depends on the seed and the drive's name. Everywhere it
// has room for a vehicle 2 m wide and 2.5 m high; its bends mostly have a radius of more than 5 m. On roads, the path
// is 2 m from the edge on the requested side, or in the middle if the road is narrower than 4 m. In open places, the
// path turns or goes straight on at random, and prefers places that it has not passed yet. Throws InputError if the
// scene has no such surface or no path of this length.
std::vector<Vec3d> findRandomPath(const SceneProbe& probe, const RandomPath& request, std::uint64_t seed,
                                  const std::string& name);

}  // namespace scanmill
