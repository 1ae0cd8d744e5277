#pragma once

// How the things of a scene move during a shot: for the columns and classes that tell.

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
  // Whether such columns or classes are asked for, in a scene in which anything moves.
  static bool areToldOf(const Scene& scene, const ScanLayout& layout);

  // The scene must outlive it. Where nothing moves it has no things.
  ThingMotions(const Scene& scene, const Shot& shot);

  // The class of points on a thing: where it moves, the ontology's class for that, if there is one.
  std::uint16_t classOf(std::uint16_t semantic, std::uint32_t thing) const;
  bool tellsClasses() const { return !things_.empty() && !movingClasses_.empty(); }

  // m/s over ground, world axes, of a thing's surface at a place (m, world): as its beams meet it, on straight lines
  // over the revolution. Zero for what stands still, and for what is no thing.
  Vec3d velocity(std::uint32_t thing, const Vec3d& place) const;

  // m over ground, world axes: from a place (m, world) on a thing's triangle, `primitive`, at a time (s since the start
  // of the revolution; the shot's own where nothing moves during one) to where the same place of the surface is when
  // the next frame is as old, carried by the thing and its animation. Zero for what stands still, and for what is no
  // thing.
  Vec3d flow(std::uint32_t thing, std::uint32_t primitive, const Vec3d& place, double time) const;

 private:
  Vec3d flowOf(const Instance& instance, std::uint32_t primitive, const Vec3d& place, double time) const;

  struct Motion {
    Vec3d pivot;    // m, world: a place of the thing, in the middle of the revolution
    Vec3d ofPivot;  // m/s
    Mat3 perMetre;  // m/s for each metre from the pivot
  };
  const Scene& scene_;
  double time_;       // s, of the shot
  double duration_;   // s
  double untilNext_;  // s
  std::unordered_map<std::uint32_t, Motion> things_;
  std::unordered_multimap<std::uint32_t, std::uint32_t> instances_;  // of each thing
  std::map<std::uint16_t, std::uint16_t> movingClasses_;             // by the class of what stands still
};

}  // namespace scanmill
