#pragma once

// How the object instances of a scene move during a shot, for the columns and classes that depend on motion.

#include <cstdint>
#include <map>
#include <unordered_map>

#include "base/vec.h"
#include "scan/scan.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

class ThingMotions {
 public:
  // True if the scene moves and the layout has a column, or the ontology a class, that depends on motion.
  static bool areToldOf(const Scene& scene, const ScanLayout& layout);

  // Computes the motion of each instance that moves. The scene must outlive this object.
  ThingMotions(const Scene& scene, const Shot& shot);

  // Returns the class of points on an instance whose class is `semantic`. If the instance moves, and the ontology has a
  // class for moving objects of this kind ("moving-car" for "car"), this is that class, else `semantic`.
  std::uint16_t classOf(std::uint16_t semantic, std::uint32_t thing) const;
  bool tellsClasses() const { return !things_.empty() && !movingClasses_.empty(); }

  // Returns the velocity over ground (m/s, world axes) of an instance's surface at a place (m, world), with motion
  // taken as linear over the revolution. Zero if the instance stands still, or if `thing` is 0 (no instance).
  Vec3d velocity(std::uint32_t thing, const Vec3d& place) const;

  // Returns how far a point of an instance's surface moves over ground (m, world axes) from `time` (s since the start
  // of the revolution; 0 if nothing moves during a revolution) to the same time in the next frame, through the movement
  // of the instance and its animation. `place` (m, world) is the point at `time`, and `primitive` its triangle. Zero if
  // the instance stands still, or if `thing` is 0 (no instance).
  Vec3d flow(std::uint32_t thing, std::uint32_t primitive, const Vec3d& place, double time) const;

 private:
  Vec3d flowOf(const Instance& instance, std::uint32_t primitive, const Vec3d& place, double time) const;

  struct Motion {
    Vec3d pivot;    // m, world: the origin of the mesh in the middle of the revolution
    Vec3d ofPivot;  // m/s, velocity of the pivot
    Mat3 perMetre;  // m/s for each metre from the pivot
  };
  const Scene& scene_;
  double time_;       // s, of the shot
  double duration_;   // s
  double untilNext_;  // s
  std::unordered_map<std::uint32_t, Motion> things_;
  std::unordered_multimap<std::uint32_t, std::uint32_t> instances_;  // by instance id: index into Scene::instances
  std::map<std::uint16_t, std::uint16_t> movingClasses_;             // by class of still objects: that of moving ones
};

}  // namespace scanmill
