#pragma once

// World descriptions as assets: an object of a scene can name a world description like any other 3D file.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "assets/asset.h"
#include "assets/worlds/xml.h"
#include "base/error.h"
#include "base/format_support.h"
#include "scene/scene.h"

namespace scanmill {

// Reads a world description with all files that it names. For 3D Tiles see readTileset(). In SDF and URDF each model
// has one node index; its parts are named "model/link/visual" or, if a mesh has nodes, "model/link/visual/node". If a
// model is included several times under names that differ only in the numbers at their ends, the copies share their
// meshes (Asset::instanced), and their common name lacks the number. A model with visuals is one thing, together with
// all models nested in it. A model without visuals is not a thing, but the models nested in it are: a single one has
// the name of the model around it, several are called "model/nested". Throws InputError with the place in the file, for
// example with all models and meshes that are missing unless AssetOptions::leaveOutMissing is set, and warns of
// contents that are left out.
Asset readWorld(const std::filesystem::path& file, std::string_view suffix, const AssetOptions& options);

// States what the reader of 3D Tiles reads and leaves out.
extern const FormatSupport kTilesetFormat;

// Reads 3D Tiles 1.0 and 1.1 (OGC 22-025r4), as kTilesetFormat says. If the tileset is on the earth, the asset's
// origin is the middle of the first tile whose middle is on the earth's surface, usually the root; x is east, y north
// and z up. A node's name begins with the content's path relative to the tileset and a slash. Throws an InputError that
// names the file.
Asset readTileset(const std::filesystem::path& file, const AssetOptions& options);

// Thrown for a file that another file names and that is missing.
class MissingFileError : public InputError {
 public:
  MissingFileError(const Location& at, const std::string& uri, const std::string& message)
      : InputError(at, message), name(uri), where(at) {}

  std::string name;  // name of the file, as the other file states it
  Location where;
};

// Adds the names of missing files to `leftOut` if `leaveOut`. Otherwise, if any file is missing, throws one InputError,
// which gives the message about the first file, and the names and places of all others.
void reportMissing(const std::vector<MissingFileError>& missing, bool leaveOut, LeftOut& leftOut);

// Returns the file or folder that the element `from` of `file` calls `uri`: model://NAME/..., package://NAME/... (see
// assets/meshes/references.h), file://... or a path relative to the file. Throws MissingFileError at `from` if
// there is none.
std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri);

// The contents of world descriptions: solids, and placed meshes from other files.

struct MeshFile {
  std::filesystem::path path;
  std::string submesh = {};  // the only node of the mesh to use; empty: all nodes
  bool centred = false;      // true: the submesh is moved so that its middle is the origin
};

struct WorldPart {
  std::string node;                      // path within the thing, such as "link/visual"
  std::variant<Mesh, MeshFile> shape{};  // a solid or a mesh
  Affine thingFromPart;                  // includes the part's scale
  std::string material{};                // name of the material of a solid, or of a mesh whose file names no material
  std::optional<std::array<float, 3>> color{};
  std::filesystem::path texture{};               // replaces the mesh's texture; empty: the mesh keeps its texture
  std::optional<float> roughness{}, metallic{};  // replace the values of the mesh's materials
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
  std::vector<MissingFileError> missing;  // missing models, meshes and heightmaps
};

// States what the reader of SDF reads and leaves out.
extern const FormatSupport kSdfFormat;

// Reads the Simulation Description Format, versions 1.3 to 1.12 (sdformat.org/spec), as kSdfFormat says. Throws
// InputError with the file and its line.
WorldFile readSdf(const std::filesystem::path& file);

// States what the reader of URDF reads and leaves out.
extern const FormatSupport kUrdfFormat;

// Reads the Unified Robot Description Format (wiki.ros.org/urdf/XML), as kUrdfFormat says. `joints`: see
// AssetOptions::joints.
WorldFile readUrdf(const std::filesystem::path& file, const std::map<std::string, double>& joints);
// Returns the transform from a link's frame to the frame of the robot's root link. Throws InputError.
Affine robotFromLink(const std::filesystem::path& urdf, const std::map<std::string, double>& joints,
                     const std::string& link);
// Returns the names of a robot's links, the root link first. Throws InputError.
std::vector<std::string> readLinkNames(const std::filesystem::path& urdf);

}  // namespace scanmill
