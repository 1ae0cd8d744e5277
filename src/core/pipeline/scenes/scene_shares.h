#pragma once

// Adjusts procedural towns until classes have the shares of hits that the scene file asks for.

#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scenefile/scene_file.h"

namespace scanmill {

// Measures ShareBound::found for each of the scene's bounds: the fraction of hits that have one of the bound's classes.
// The hits are those of a sensor with 64 rings and a range of 100 m, at poses along the polyline `lane` (world frame,
// m), 1.73 m above it. Objects are at their positions at time 0 s.
void measureShares(Scene& scene, const std::vector<Vec3d>& lane);

// Reads a scene file like readScene(). If its town bounds the shares of classes among the hits, varies the number of
// plants, vehicles and people until a sensor above the lane measures shares within the bounds, or as close to them as
// possible. The reached shares are then appended to Scene::about. Roads, plots and houses depend only on the seed.
// Throws InputError with file and line.
Scene readSceneToShares(const std::filesystem::path& file, SceneOptions options);

// Returns a warning for each share that is outside of its bounds.
std::vector<std::string> shareWarnings(const Scene& scene);

}  // namespace scanmill
