#pragma once

// Lists what the sensors of a sample see of each object of the scene. The list is the sample's member
// `<key>.objects.json`.

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/recently_used.h"
#include "dataset/objects.h"
#include "methods/method.h"
#include "methods/ray_tracing/unobstructed.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "scene/thing_boxes.h"
#include "sense/returns.h"
#include "sensors/beam_grid.h"
#include "sensors/shot.h"

namespace scanmill {

// The objects of a scene, with the data that tests of their visibility need. Built once; safe to use from several
// threads.
class SceneObjects {
 public:
  // Tests visibility with the ray-tracing hierarchies (Worlds) of the method, or builds them if the method has none.
  // Scene and method must outlive this object.
  SceneObjects(const Scene& scene, const Method& method);

  const ThingBoxes& boxes() const { return boxes_; }
  const Unobstructed& unobstructed() const { return unobstructed_; }
  // Returns the memory of the hierarchies that this object has built (bytes); 0 if it uses those of the method.
  std::uint64_t memoryBytes() const;
  std::shared_ptr<const BeamGrid> gridOf(const std::shared_ptr<const BeamTable>& beams) const;

 private:
  struct Grid {
    std::shared_ptr<const BeamTable> beams;
    std::shared_ptr<const BeamGrid> grid;
  };

  ThingBoxes boxes_;
  std::unique_ptr<const Worlds> own_;  // null: the method's Worlds are used
  Unobstructed unobstructed_;
  mutable std::mutex mutex_;
  mutable RecentlyUsed<Grid> grids_;
};

// The object list of one sample.
class ObjectList {
 public:
  // `time`: the time of the sample (s since the start of the sequence), for which the boxes are computed.
  ObjectList(const SceneObjects& objects, std::string key, double time);

  // Adds what a shot sees of each object that it hits or has within the sensor's range. `hits`, `returns`: the hits and
  // returns from which the shot's scan was made; hits need the channel Instance. `raysPerBeam`: number of rays per
  // beam; the first ray of each beam is its axis.
  void add(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits, const Returns& returns);

  // Returns the objects that at least one shot hits or has within its sensor's range, sorted by id.
  [[nodiscard]] SampleObjects finish() const;

 private:
  const SceneObjects& objects_;
  std::string key_;
  double time_;
  std::vector<OrientedBox> boxes_;              // one per object instance, in the order of SceneObjects::boxes()
  std::vector<std::vector<ObjectView>> views_;  // for each object instance, one view per shot that reaches it
};

}  // namespace scanmill
