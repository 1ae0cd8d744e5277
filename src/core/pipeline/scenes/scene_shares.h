#pragma once

// Scenes whose towns ask for shares of classes.

#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scenefile/scene_file.h"

namespace scanmill {

// Sets ShareBound::found of the scene's bounds: the share of the hits that are of its classes, over places all along
// these (m, world), in what a sensor of 64 rings 1.73 m above them meets up to 100 m away, as all stands at the time 0.
void measureShares(Scene& scene, const std::vector<Vec3d>& lane);

// Reads a scene file as readScene() does. Where its town asks for shares, it has more or fewer plants, vehicles and
// people until a sensor above the lane meets what was asked for, or comes as near to it as can be; Scene::about tells
// what it meets then. The roads, plots and houses stay those of the seed. Throws InputError with the place.
Scene readSceneToShares(const std::filesystem::path& file, SceneOptions options);

// The bounds that are not met: a line each.
std::vector<std::string> shareWarnings(const Scene& scene);

}  // namespace scanmill
