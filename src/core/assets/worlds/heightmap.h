#pragma once

// Terrain of SDF: a <heightmap> names an image or a digital elevation model.

#include <filesystem>

#include "assets/worlds/xml.h"
#include "scene/scene.h"

namespace scanmill {

// Returns the surface of a <heightmap> as Gazebo builds it: centred at <pos>, with the first row of samples at the
// greatest y. The first band of a PNG, a JPEG or another raster without georeference rises from 0 to <size>'s z, which
// stands for its greatest value. The heights of a raster with georeference rise from its least to its greatest value;
// without <size> it has its own size. <sampling> samples per pixel are interpolated. Samples without a value leave
// holes. Throws InputError that names `shape` or the file.
Mesh heightmapOf(const XmlNode& shape, const std::filesystem::path& file);

}  // namespace scanmill
