#pragma once

// Oriented bounding boxes, at any time, of the things of a scene: the objects with instance ids.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/placements.h"
#include "scene/scene.h"

namespace scanmill {

// A box around a thing: the smallest of all boxes along the axes of `worldFromBox`.
struct OrientedBox {
  Pose worldFromBox;  // pose of the box's centre; x forward, y left, z up for the thing
  Vec3d size;         // m: length along x, width along y, height along z

  // Returns the eight corners in the world's frame (m).
  std::vector<Vec3d> corners() const;
};

// Returns the direction (rad) of the longer sides of the smallest rectangle around the points. A side of this rectangle
// lies along a side of the points' convex hull (Freeman and Shapira, "Determining the minimum-area encasing rectangle
// for an arbitrary closed curve", Communications of the ACM 18 (1975)).
double longSideOf(std::vector<Vec2d> points);

struct Thing {
  std::uint32_t id = 0;            // instance id, 1 or more
  std::uint16_t semantic = 0;      // the most frequent class of the thing's triangles
  std::string name;                // name of the instance with most of the thing's triangles
  std::vector<std::string> parts;  // names of the thing's nodes, sorted, without duplicates; "": a node without a name
  // True: the box has the axes of the placed object, turned so that x is the direction in which the object faces
  // (Instance::facing). False if the mesh has several things and `facing` is not set: then the box has the smallest
  // possible footprint, x lies along the footprint's longer side, and front and back are unknown.
  bool headingKnown = true;
  bool moves = false;
};

// Computes the boxes of the things of a scene, which must outlive this object. Safe to use from several threads. Boxes
// are computed in double from the corners of the triangles. They are exact, unless the parts of a thing move
// differently. If a thing consists of several objects, the object with the most triangles gives the axes.
class ThingBoxes {
 public:
  // `classes`: the ids of the classes whose things are meant; empty: all classes.
  explicit ThingBoxes(const Scene& scene, const std::vector<std::uint16_t>& classes = {});

  // Returns the things in ascending order of their ids.
  const std::vector<Thing>& things() const { return things_; }
  // Returns the box of a thing at a time (s since the drive began), in the shape that an animated thing has at that
  // time. `thing`: an index into things(). `placed`: see Shot::placed; parts that the shot leaves out are not in the
  // box.
  OrientedBox at(std::size_t thing, double time, const Placements* placed = nullptr) const;
  // Returns the velocity of the thing's frame over ground (m/s, world axes), without the motion that an animation adds.
  Vec3d velocity(std::size_t thing, double time, const Placements* placed = nullptr) const;
  // Returns the placement of the thing's first part in a shot; null if the part is where the scene has it.
  const RigidMotion* placement(std::size_t thing, const Placements* placed) const;

 private:
  // A part of a thing: one object of one instance.
  struct Part {
    std::uint32_t instance = 0;  // index in Scene::instances
    std::uint32_t object = 0;    // see Surface::object
    std::vector<Box> boxes{};    // m, in the thing's frame at time 0; one per mesh of an animation, else one
  };
  struct Shape {
    Pose worldFromThing;      // pose at time 0
    std::vector<Part> parts;  // the thing has the axes of the first part
  };

  class Builder;  // finds the things of a scene and their boxes

  const Scene& scene_;
  std::vector<Thing> things_;
  std::vector<Shape> shapes_;  // by index in things_
};

}  // namespace scanmill
