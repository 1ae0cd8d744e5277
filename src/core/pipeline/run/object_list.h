#pragma once

// Lists what the sensors of a sample see of each object of the scene, for the member `<key>.objects.json`.

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

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

// The objects of a scene, with all that visibility tests of them need. Built once; safe to use from several threads.
class SceneObjects {
 public:
  // Tests visibility in the Worlds of the method if it has some, else in Worlds of its own. Scene and method must
  // outlive this object.
  SceneObjects(const Scene& scene, const Method& method);

  const ThingBoxes& boxes() const { return boxes_; }
  const Unobstructed& unobstructed() const { return unobstructed_; }
  // Returns the bytes that it takes besides those of the method.
  std::uint64_t memoryBytes() const;
  std::shared_ptr<const BeamGrid> gridOf(const std::shared_ptr<const BeamTable>& beams) const;

 private:
  struct Grid {
    std::shared_ptr<const BeamTable> beams;
    std::shared_ptr<const BeamGrid> grid;
  };

  ThingBoxes boxes_;
  std::unique_ptr<const Worlds> own_;  // null: those of the method are used
  Unobstructed unobstructed_;
  mutable std::mutex mutex_;
  mutable std::list<Grid> grids_;  // the most recently used first
};

// The object list of one sample.
class ObjectList {
 public:
  // `time`: of the sample (s since the start of the sequence); the boxes are given for this time.
  ObjectList(const SceneObjects& objects, std::string key, double time);

  // Adds what a shot sees of each object within its reach. `hits` and `returns` are those from which the shot's scan
  // was made; hits need the channel Instance. `raysPerBeam`: rays of a beam, of which the first is the beam's axis.
  void add(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits, const Returns& returns);

  // Returns the objects that were within the reach of any shot, sorted by id.
  [[nodiscard]] SampleObjects finish() const;

 private:
  ObjectRecord recordOf(std::size_t thing) const;

  const SceneObjects& objects_;
  std::string key_;
  double time_;
  std::vector<OrientedBox> boxes_;              // one per thing
  std::vector<std::vector<ObjectView>> views_;  // one list per thing
};

}  // namespace scanmill
