#pragma once

// The materials of an imported file, with the images that they name.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"

namespace scanmill {

// Returns the looks of the imported file's materials, in its order. Warns of missing and broken textures. Throws
// InputError for a texture outside of the file's folder, unless AssetOptions::allowOutside is set. Adds what is not
// modelled to `leftOut`.
std::vector<Look> readMaterials(const ImportedFile& imported, const std::filesystem::path& file,
                                const AssetOptions& options, LeftOut& leftOut);

// Fractions of the total area of the triangles that have one material and texture coordinates; all 0 if there are no
// such triangles or the texture has no alpha.
struct AlphaShares {
  double low = 0;     // area with alpha below 0.5
  double graded = 0;  // area with alpha from 0.1 to 0.9
  double gone = 0;    // area of triangles on which alpha is below 0.5 everywhere
};

// True if these are the fractions of cut-outs: some of the surface is cut away, the alpha is mostly 0 or 1, and hardly
// any triangle would vanish completely, since nobody models triangles that are never seen. If alpha instead marks the
// painted parts of a car's body, complete panels have a low alpha. In measurements on Gazebo's models, 0 and 8 % of the
// area would vanish from the branches of oak and pine, and 24, 35 and 53 % from the bodies of bus, hatchback and SUV.
bool isCutOut(const AlphaShares& shares);

}  // namespace scanmill
