#pragma once

// Height rasters (digital elevation models) as assets.

#include <filesystem>
#include <string_view>

#include "assets/asset.h"

namespace scanmill {

// True if files with this suffix (".tif", lower case) are read as height rasters.
bool isHeights(std::string_view suffix);

// Reads band 1 of a raster as heights in metres. Each square of four samples becomes two triangles, split along the
// shorter diagonal; a sample without a value leaves a hole. If the raster's coordinates are projected, the asset has
// the same x and y, in metres. If they are longitude and latitude, x and y are metres east and north of the raster's
// middle, and z is the height above the horizontal plane at the middle. AssetOptions::heights can add a class raster:
// the triangles of each class are then a part, whose material is the class number. Otherwise all triangles are one part
// with the material "heights". Throws an InputError that names the file.
Asset readHeightAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
