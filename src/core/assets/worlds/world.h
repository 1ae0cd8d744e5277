#pragma once

// The contents of world descriptions: solids, and placed meshes from other files.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "assets/worlds/named_files.h"
#include "base/error.h"
#include "base/format_support.h"
#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

struct WorldPart {
  std::string node;            // path within the thing, such as "link/visual"
  std::filesystem::path mesh;  // empty: the part is a solid
  std::string submesh;         // the only node of the mesh to use; empty: all nodes
  bool centred = false;        // true: the submesh is moved so that its middle is the origin
  std::optional<Mesh> solid;
  Affine thingFromPart;  // includes the part's scale
  std::string material;  // name of the material of a solid, or of a mesh whose file names no material
  std::optional<std::array<float, 3>> color;
  std::filesystem::path texture;             // replaces the mesh's texture; empty: the mesh keeps its texture
  std::optional<float> roughness, metallic;  // replace those of the mesh's materials
  Location where;
};

// A model or a robot: its parts move together.
struct WorldThing {
  std::string name;
  std::filesystem::path definition;  // file of an included model, shared by all its copies; else empty
  Affine worldFromThing;             // translation in m, z up
  std::vector<WorldPart> parts;
};

struct WorldFile {
  std::vector<WorldThing> things;
  LeftOut leftOut;
  MissingFiles missing;  // models, meshes and heightmaps; the things lack them
};

// Returns what the reader of SDF reads and leaves out.
const FormatSupport& sdfFormat();

// Reads the Simulation Description Format, versions 1.3 to 1.12 (sdformat.org/spec): .sdf and .world. sdfFormat() says
// what is read. COLLADA's up_axis is ignored, as in Gazebo. Throws InputError with the file and its line.
WorldFile readSdf(const std::filesystem::path& file);

// Returns what the reader of URDF reads and leaves out.
const FormatSupport& urdfFormat();

// Reads the Unified Robot Description Format (wiki.ros.org/urdf/XML): visuals of links, with all joints at zero.
WorldFile readUrdf(const std::filesystem::path& file);

}  // namespace scanmill
