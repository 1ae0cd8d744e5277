#pragma once

// Adapts scenes whose towns ask for shares of classes among the hits.

#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scenefile/scene_file.h"

namespace scanmill {

// Sets ShareBound::found of each of the scene's bounds: the share of hits whose class is one of the bound's. The hits
// are those of a sensor with 64 rings and a range of 100 m, which scans from poses all along `lane` (m, world), 1.73 m
// above it. Objects are where they are at the time 0.
void measureShares(Scene& scene, const std::vector<Vec3d>& lane);

// Reads a scene file as readScene() does. If its town asks for shares, varies the number of plants, vehicles and people
// until the hits of a sensor above the lane have these shares, or come as near to them as possible; Scene::about then
// ends with the shares that were reached. Roads, plots and houses stay those of the seed. Throws InputError with the
// place.
Scene readSceneToShares(const std::filesystem::path& file, SceneOptions options);

// Returns a warning for each bound that is not met.
std::vector<std::string> shareWarnings(const Scene& scene);

}  // namespace scanmill
