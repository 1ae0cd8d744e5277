#pragma once

// Reads scene files (scenes/*.yaml; scene_file.cpp describes their keys).
//
//   const Scene scene = readScene("scenes/street.yaml", {.seed = 7});

#include <cstdint>
#include <filesystem>
#include <optional>

#include "scene/lanes.h"
#include "scene/scene.h"

namespace scanmill {

struct SceneOptions {
  std::uint64_t seed = 1;          // seed of everything random in the scene
  std::filesystem::path ontology;  // if not empty, replaces the one that the scene names
  int wavelengthNm = 905;          // wavelength at which the material table is read
  bool textures = true;            // false: no base colour is loaded unless alpha needs it
  SupplyFactors supply{1, 1, 1};   // factors for towns, on top of those in their files
};

// Reads a scene file, such as those in scenes/, with all the files that it names. Throws InputError with the place.
Scene readScene(const std::filesystem::path& path, const SceneOptions& options);

// Returns the lanes and turns through the first town of a scene file with this seed, in the world frame, without
// building any geometry; nothing if the scene has no town. Throws InputError with the place.
std::optional<SceneLanes> readSceneLanes(const std::filesystem::path& path, std::uint64_t seed);

// Reads the ontology that a scene file names, and nothing else of the scene. Throws InputError with the place.
Ontology readSceneOntology(const std::filesystem::path& path);

}  // namespace scanmill
