#pragma once

// Functions that print what `scanmill info` shows of one kind of file, and fieldOf() for tables of sensors.

#include <array>
#include <cstdint>
#include <filesystem>

#include "assets/asset.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the horizontal and the vertical field of view of the beams (deg). The horizontal field is 360 degrees if no
// gap between neighbouring azimuths reaches 5 degrees.
std::array<double, 2> fieldOf(const BeamTable& beams);
// Prints a scene file. `seed`: seed of a procedural scene.
void printScene(const std::filesystem::path& file, std::uint64_t seed);
// Prints a 3D file; also its colours if `options.textures` is true.
void printAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
