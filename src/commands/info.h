#pragma once

// The parts of `scanmill info`: each prints what the command shows of one kind of file.

#include <array>
#include <cstdint>
#include <filesystem>

#include "assets/asset.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the horizontal and the vertical field of view of the beams (deg). A horizontal gap of less than 5 degrees
// counts as none.
std::array<double, 2> fieldOf(const BeamTable& beams);
// Prints a scene file. `seed`: seed of a procedural scene.
void printScene(const std::filesystem::path& file, std::uint64_t seed);
// Prints a 3D file; also its colours if `options.textures` is true.
void printAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
