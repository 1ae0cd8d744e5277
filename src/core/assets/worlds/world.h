#pragma once

// What descriptions of worlds place: meshes of other files, and solids.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

struct WorldPart {
  std::string node;            // "link/visual": its path in the thing
  std::filesystem::path mesh;  // empty: a solid
  std::string submesh;         // the one of the mesh's nodes that is taken; empty: all
  bool centred = false;        // that is moved to its own middle
  std::optional<Mesh> solid;
  Affine thingFromPart;  // with the part's scale
  std::string material;  // of a solid, and of a mesh that has none of its own
  std::optional<std::array<float, 3>> color;
  std::filesystem::path texture;     // in place of that of the mesh; empty: none
  std::optional<float> alphaCutoff;  // of that: below, beams pass
  Location where;
};

// A model or a robot: its parts move together.
struct WorldThing {
  std::string name;
  std::filesystem::path definition;  // where it comes from, of those that are the same wherever they stand; else empty
  Affine worldFromThing;             // m, z up
  std::vector<WorldPart> parts;
};

struct World {
  std::vector<WorldThing> things;
  std::vector<std::string> leftOut;  // what it holds that is no geometry of ours, in words
};

// The Simulation Description Format, versions 1.0 to 1.11 (sdformat.org/spec): .sdf and .world. Visuals of links, poses
// that are relative to links, joints, models and frames; models of models, included ones, nested ones; meshes, boxes,
// cylinders, cones, spheres, capsules, ellipsoids, planes. Gazebo does not look at COLLADA's up_axis, and so it is
// here. Throws InputError with the file and its line, such as for a model that is not found.
World readSdf(const std::filesystem::path& file);

// The Unified Robot Description Format (wiki.ros.org/urdf/XML): visuals of links, all joints at zero.
World readUrdf(const std::filesystem::path& file);

}  // namespace scanmill
