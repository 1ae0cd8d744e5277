#pragma once

// Rasters of heights (digital elevation models) as assets.

#include <filesystem>
#include <string_view>

#include "assets/asset.h"

namespace scanmill {

// Whether files of this suffix (".tif", lower case) are taken for rasters of heights.
bool isHeights(std::string_view suffix);

// Reads band 1 of a raster as heights in metres. Four samples make two triangles, across the shorter diagonal; where a
// sample has no value there is a hole. Of projected coordinates x and y are those of the raster, in metres; of
// longitude and latitude they are metres east and north of the raster's middle, and z is the height above the horizon
// there (AssetOptions::heights for what else). Parts are the triangles of one class of the raster of classes, whose
// material is its number; without one all is one part of the material "heights". Throws InputError that names the file.
Asset readHeightAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
