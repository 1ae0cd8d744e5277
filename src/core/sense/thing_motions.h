#pragma once

// The motion of a scene's object instances during a shot, for the columns and classes that depend on motion.
//
//   const ThingMotions motions(scene, shot);
//   const Vec3d velocity = motions.velocity(17, {10, 0, 0});  // velocity of object 17 at a point (m/s)

#include <cstdint>
#include <map>
#include <memory>
#include <unordered_map>

#include "base/vec.h"
#include "scan/scan.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

class ThingMotions {
 public:
  // Returns true if objects of the scene move, and the layout has a column or the ontology has a class that depends on
  // motion.
  static bool areToldOf(const Scene& scene, const ScanLayout& layout);

  // Computes the motion of each instance that moves. The scene must outlive this object.
  ThingMotions(const Scene& scene, const Shot& shot);

  // Returns the class of points on an instance whose class is `semantic`: for an instance that moves, the ontology's
  // class for moving objects of this kind ("moving-car" for "car"); otherwise, or if there is no such class,
  // `semantic`.
  std::uint16_t classOf(std::uint16_t semantic, std::uint32_t thing) const;
  bool tellsClasses() const { return !things_.empty() && !movingClasses_.empty(); }

  // Returns the velocity over ground (m/s, world axes) of an instance's surface at a point (m, world). The motion is
  // assumed to be linear during the revolution. Zero if the instance stands still, or if `thing` is 0 (no instance).
  Vec3d velocity(std::uint32_t thing, const Vec3d& place) const;

  // Returns the displacement over ground (m, world axes) of a point of an instance's surface, from `time` (s since the
  // start of the revolution; 0 if nothing moves during a revolution) to the same time in the next frame, by the
  // movement of the instance and its animation. `place` (m, world) is the point at `time`, and `primitive` its
  // triangle. Zero if the instance stands still, or if `thing` is 0 (no instance).
  Vec3d flow(std::uint32_t thing, std::uint32_t primitive, const Vec3d& place, double time) const;

 private:
  Vec3d flowOf(std::uint32_t instance, std::uint32_t primitive, const Vec3d& place, double time) const;

  struct Motion {
    Vec3d pivot;    // m, world: origin of the mesh in the middle of the revolution
    Vec3d ofPivot;  // m/s, velocity of the pivot
    Mat3 perMetre;  // m/s per metre of distance from the pivot
  };
  const Scene& scene_;
  std::shared_ptr<const Placements> placed_;  // see Shot::placed
  double time_;                               // s, start of the shot
  double duration_;                           // s, duration of the revolution
  double untilNext_;                          // s, time from the shot to the next frame
  std::unordered_map<std::uint32_t, Motion> things_;
  std::unordered_multimap<std::uint32_t, std::uint32_t> instances_;  // indices into Scene::instances, by instance id
  std::map<std::uint16_t, std::uint16_t> movingClasses_;             // for a class of objects at rest, the class of the
                                                                     // same objects in motion
};

}  // namespace scanmill
