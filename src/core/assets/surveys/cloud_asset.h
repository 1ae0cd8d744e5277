#pragma once

// Clouds of points as assets: a place that was recorded can be scanned again, by another sensor.

#include <filesystem>

#include "assets/asset.h"

namespace scanmill {

// AssetPart::texture of points whose reflectance comes from intensities; of those that have colours it is kPointColor.
inline constexpr const char* kPointIntensity = "intensity";
inline constexpr const char* kPointColor = "color";

// Reads a file of which isCloud() holds (formats/cloud_file.h). Each point becomes a square as large as the disc of its
// surfel (surfels.h), two triangles that every method traces. Parts are the points of one label and one instance: the
// part's material is the label's name (AssetOptions::points), or its number, also what it is of by itself
// (AssetPart::ownClass); its node is "instance 7" where the points have instances. LAS calls its labels by the names of
// its specification ("ground", "building", "high vegetation"); those that it calls noise are left out. Reflectance is
// the points' own: from intensity, else from colours. Throws InputError that names the file.
Asset readCloudAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
