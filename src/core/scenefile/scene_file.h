#pragma once

// Reads scene files (scenes/*.yaml), whose keys docs/keys.md lists.
//
//   const Scene scene = readScene("scenes/street.yaml", {.seed = 7});

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "scene/builder.h"
#include "scene/scene.h"

namespace scanmill {

struct SceneOptions {
  std::uint64_t seed = 1;            // seed of all random numbers of the scene
  std::filesystem::path ontology{};  // if not empty, replaces the ontology that the scene file names
  int wavelengthNm = 905;            // nm, wavelength for which the material table is read
  bool textures = true;              // false: only textures for cut-outs and for rules about colours are loaded
  // If not null, adds further objects after the objects of the file, whose list of objects may then be empty.
  std::function<void(SceneBuilder&)> add = nullptr;
};

// Reads a scene file, such as those in scenes/, with all the files that it names. Throws InputError with the place.
Scene readScene(const std::filesystem::path& path, const SceneOptions& options);

// Returns the lanes of a scene file's town and the turns between them (m, world frame); nothing if the scene has no
// town. Builds no geometry. Throws InputError with the place.
std::optional<SceneLanes> readSceneLanes(const std::filesystem::path& path, std::uint64_t seed);

// Returns the pose of a link of the scene's first object that is a URDF file, in the scene's frame, with the object's
// `joints`. `where`: the place that names the link. Throws InputError.
Pose readLinkPose(const std::filesystem::path& path, const std::string& link, const Location& where);

// Reads only the ontology that a scene file names. Throws InputError with the place.
Ontology readSceneOntology(const std::filesystem::path& path);

}  // namespace scanmill
