#pragma once

// What the sensors of a sample see of the things of its scene, as the member `<key>.objects.json` has it.

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

// The things of a scene and what is needed to look at them. Made once; safe to use from several threads.
class SceneObjects {
 public:
  // Looks at them in the worlds of the method where it has some, else in worlds that it makes. Both must outlive it.
  SceneObjects(const Scene& scene, const Method& method);

  const ThingBoxes& boxes() const { return boxes_; }
  const Unobstructed& unobstructed() const { return unobstructed_; }
  // What it takes besides the method.
  std::uint64_t memoryBytes() const;
  std::shared_ptr<const BeamGrid> gridOf(const std::shared_ptr<const BeamTable>& beams) const;

 private:
  struct Grid {
    std::shared_ptr<const BeamTable> beams;
    std::shared_ptr<const BeamGrid> grid;
  };

  ThingBoxes boxes_;
  std::unique_ptr<const Worlds> own_;  // null: the method's serve
  Unobstructed unobstructed_;
  mutable std::mutex mutex_;
  mutable std::list<Grid> grids_;  // those used last come first
};

// Of one sample.
class ObjectList {
 public:
  // `time`: of the sample (s since the start of the sequence), at which the boxes are given.
  ObjectList(const SceneObjects& objects, std::string key, double time);

  // Looks at all that is within the reach of a shot, whose hits need the channel Instance. The hits and returns are
  // those that the scan was made of. `raysPerBeam`: that were fired, each beam's axis first.
  void add(const Shot& shot, std::uint32_t raysPerBeam, const Hits& hits, const Returns& returns);

  // What has been within the reach of any shot, by ids.
  SampleObjects finish() const;

 private:
  ObjectRecord recordOf(std::size_t thing) const;

  const SceneObjects& objects_;
  std::string key_;
  double time_;
  std::vector<OrientedBox> boxes_;              // of all things
  std::vector<std::vector<ObjectView>> views_;  // likewise
};

}  // namespace scanmill
