#pragma once

// Point clouds as assets: a recorded place can be scanned again, by another sensor.

#include <filesystem>

#include "assets/asset.h"

namespace scanmill {

// AssetPart::texture of points: where their reflectance comes from.
inline constexpr const char* kPointIntensity = "intensity";
inline constexpr const char* kPointColor = "color";

// Reads a file for which isCloud() is true (formats/cloud_file.h). Each point becomes a square with the area of its
// surfel's disc (surfels.h): two triangles, which every method can trace. The points of one label and one instance form
// a part. The part's material and AssetPart::ownClass are the label's name (AssetOptions::points), or else its number;
// its node is "instance 7" if the points have instances. Labels of LAS have the names of its specification ("ground",
// "building", "high vegetation"), and points that LAS calls noise are dropped, unless AssetOptions::points has labels.
// Reflectance is that of the points: from intensities, else from colours. Throws an InputError that names the file.
Asset readCloudAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
