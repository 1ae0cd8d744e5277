#pragma once

// The things of a scene, that have instance ids, and their boxes at any time.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// The smallest box in given axes about what is in it.
struct OrientedBox {
  Pose worldFromBox;  // of its middle; x forward, y left, z up, as the thing has them
  Vec3d size;         // m: length along x, width along y, height along z

  // The eight corners in the world's frame (m).
  std::vector<Vec3d> corners() const;
};

struct Thing {
  std::uint32_t id = 0;            // instance id, 1 or more
  std::uint16_t semantic = 0;      // the class of most of its triangles
  std::string name;                // of the instance that most of its triangles are of
  std::vector<std::string> parts;  // names of the nodes that it is made of, in order, each once; "" is none
  // The box has the axes of the placed object, turned so that x is the way it faces (Instance::facing). False for one
  // of several things in a file, none of which is said to face any way: then its box is the one that covers least
  // ground, its length the longer side, and front and back are not told apart.
  bool headingKnown = true;
  bool moves = false;
};

// Made once for a scene, which must outlive it; safe to read from several threads. Boxes are exact: of the triangles'
// own corners, in double. Of a thing of several objects, the one of most triangles gives the axes.
class ThingBoxes {
 public:
  explicit ThingBoxes(const Scene& scene);

  // By their ids.
  const std::vector<Thing>& things() const { return things_; }
  // Its box at a time (s since the drive began); of an animated thing, of its shape at the time. `thing`: an index into
  // things().
  OrientedBox at(std::size_t thing, double time) const;
  // Of the box's axes' origin, over ground (m/s, world axes), without what an animation moves within it.
  Vec3d velocity(std::size_t thing, double time) const;

 private:
  // Of an instance, what belongs to the thing.
  struct Part {
    std::uint32_t instance = 0;
    std::uint32_t object = 0;    // see Surface::object
    std::vector<Box> ofShape{};  // in the thing's axes at the time 0; one for each mesh of an animation, else one
  };
  struct Place {
    Pose worldFromThing;      // at the time 0
    std::vector<Part> parts;  // the first gives the axes
  };

  Pose motion(const Instance& instance, double time) const;

  const Scene& scene_;
  std::vector<Thing> things_;
  std::vector<Place> places_;
};

}  // namespace scanmill
