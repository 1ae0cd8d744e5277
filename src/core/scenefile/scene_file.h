#pragma once

// Reads scene files (scenes/*.yaml; their keys stand in scene_reader.cpp).
//
//   const Scene scene = readScene("scenes/street.yaml", {.seed = 7});

#include <cstdint>
#include <filesystem>
#include <optional>

#include "scene/lanes.h"
#include "scene/scene.h"

namespace scanmill {

struct SceneOptions {
  std::uint64_t seed = 1;          // of procedural scenes
  std::filesystem::path ontology;  // overrides the scene's own where not empty
  int wavelengthNm = 905;          // of the material table
  bool textures = true;            // false: no base colour is loaded unless alpha needs it
  SupplyFactors supply{1, 1, 1};   // of towns, beside those in their files
};

// Reads a scene file, such as those in scenes/, with all the files that it names. Throws InputError with the place.
Scene readScene(const std::filesystem::path& path, const SceneOptions& options);

// The ways through the first town of a scene file with this seed, in the world's frame. No geometry is made. Throws
// InputError with the place. Absent where the scene has no town.
std::optional<SceneLanes> readSceneLanes(const std::filesystem::path& path, std::uint64_t seed);

// Reads no more of it than which ontology it names, and that. Throws InputError with the place.
Ontology readSceneOntology(const std::filesystem::path& path);

}  // namespace scanmill
