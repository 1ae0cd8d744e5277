#pragma once

// The receiver model, which turns hits into a scan in three stages: it detects, applies the effects and gathers.
//
//   const ScanLayout layout{.columns = ColumnSet::byDefault()};
//   Returns returns;
//   Scan points;
//   sense({.materials = scene.materials, .layout = layout}, hits, shot, returns, points);

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/vec.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scan/reasons.h"
#include "scan/scan.h"
#include "scene/material.h"
#include "scene/scene.h"
#include "sense/effect.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

// The motion of a scene's object instances during a shot, for the columns and classes that depend on motion:
//
//   const InstanceMotions motions(scene, shot);
//   const Vec3d velocity = motions.velocity(17, {10, 0, 0});  // velocity of object 17 at a point (m/s)
class InstanceMotions {
 public:
  // Returns true if objects of the scene move, and a column of the layout or a class of the ontology depends on motion.
  static bool areNeeded(const Scene& scene, const ScanLayout& layout);

  // Computes the motion of each instance that moves. The scene must outlive this object.
  InstanceMotions(const Scene& scene, const Shot& shot);

  // Returns the class of points on an instance that has the class `semantic` in the scene: for an instance that moves,
  // the ontology's class for moving objects of this kind ("moving-car" for "car"), if there is one; otherwise
  // `semantic`.
  std::uint16_t classOf(std::uint16_t semantic, std::uint32_t instanceId) const;
  bool haveMovingClasses() const { return !motionOf_.empty() && !movingClasses_.empty(); }

  // Returns the velocity over ground (m/s, world axes) of an instance's surface at a point (m, world). Motion is
  // assumed to be linear during the revolution. Returns zero for an instance that stands still and for `instanceId` 0.
  Vec3d velocity(std::uint32_t instanceId, const Vec3d& point) const;

  // Returns the displacement over ground (m, world axes) of a point of an instance's surface until the same time in the
  // next frame, by the instance's motion and animation. The point is at `point` (m, world) at `time` (s since the start
  // of the revolution; 0 if nothing moves during a revolution), on the triangle `primitive`. Returns zero for an
  // instance that stands still and for `instanceId` 0.
  Vec3d flow(std::uint32_t instanceId, std::uint32_t primitive, const Vec3d& point, double time) const;

 private:
  // Returns flow() for an entry of Scene::instances, by its index.
  Vec3d flowOf(std::uint32_t index, std::uint32_t primitive, const Vec3d& point, double time) const;

  struct Motion {
    Vec3d pivot;            // m, world: origin of the mesh in the middle of the revolution
    Vec3d velocityOfPivot;  // m/s
    Mat3 velocityPerMetre;  // m/s per metre of distance from the pivot
  };
  const Scene& scene_;
  std::shared_ptr<const Placements> placed_;                         // see Shot::placed
  double time_;                                                      // s, start of the shot
  double duration_;                                                  // s, duration of the revolution
  double untilNext_;                                                 // s, time from the shot to the next frame
  std::unordered_map<std::uint32_t, Motion> motionOf_;               // by instance id
  std::unordered_multimap<std::uint32_t, std::uint32_t> instances_;  // indices into Scene::instances, by instance id
  std::map<std::uint16_t, std::uint16_t> movingClasses_;             // for a class of objects at rest, the class of the
                                                                     // same objects in motion
};

// Returns the channels of Hits that the effects and the columns need.
Channels channelsFor(EffectList effects, ColumnSet columns);

// Starts the table of returns. If each beam fires one ray, each ray becomes a row. If beams fire several rays, each
// echo is a row (sense/returns.h), with the power that the effects compute; without a pulse length each ray is an echo.
void detect(const Hits& hits, const Shot& shot, EffectList effects, std::span<const Material> materials,
            Returns& returns);

// The settings with which hits become a scan. All objects that they refer to must outlive the receiver.
struct Receiver {
  EffectList effects = {};                   // the effects, in the order in which they run
  std::span<const Material> materials = {};  // indexed by Hits::material
  ScanLayout layout = {};                    // the columns that the scan gets
  const InstanceMotions* motions = nullptr;  // null: nothing moves, or no column or class depends on motion
};

// Makes a scan from hits: detects returns, applies the effects and gathers the columns. `returns` is a buffer, which
// later calls can reuse to avoid allocations. Throws Error if the hits lack a channel or belong to another sensor.
void sense(const Receiver& receiver, const Hits& hits, const Shot& shot, Returns& returns, Scan& scan);

// Returns one value of Reason per beam. All effects must have run, on a table that records reasons
// (Returns::recordReasons()). A beam without a return has the reason of its strongest echo. If the hits have the
// channel Material, too faint echoes have the reason LostInGlass on glass, MirroredAway on mirrors and metals.
std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns);

// Fills the scan's columns that the layout asks for; intensity and power only if an effect has set them or the table
// of returns has no rows. Dense scans are ordered by column, then ring, then return, which is the order of firing. The
// nearest return of a beam is its first. `motions`: motions of the scene's objects; null if nothing moves.
void gather(const Hits& hits, const Shot& shot, const Returns& returns, const ScanLayout& layout,
            const InstanceMotions* motions, Scan& scan);

}  // namespace scanmill
