#pragma once

// Surveys as assets. A point cloud is a recorded place, which can be scanned again by another sensor; a height raster
// is a digital elevation model.

#include <cstddef>
#include <filesystem>
#include <vector>

#include "assets/asset.h"
#include "base/vec.h"

namespace scanmill {

// A surface element (surfel): a disc that approximates a surface near a measured point (Pfister, Zwicker, van Baar,
// Gross, "Surfels: surface elements as rendering primitives", SIGGRAPH 2000).
struct Surfel {
  Vec3f normal;      // unit length; its sign is arbitrary
  float radius = 0;  // m, radius of the disc
};

// Returns one surfel per point, in the order of the points. The normal is the direction in which a point and its
// neighbours scatter least (Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992). If these
// points lie on a line, as along one ring of a scan, up to eight times as many neighbours are used. A point with n
// neighbours within the distance d represents the area pi d^2 / n of the surface. `normals` is empty or has one normal
// per point, which replaces the estimate unless it is zero. Positions must be finite. Runs on all cores.
std::vector<Surfel> surfelsOf(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                              const SurfelOptions& options);

// Keeps one point in each cube of a grid of this spacing (m): the point nearest to the cube's centre. Returns the
// indices of the kept points, ascending.
std::vector<std::size_t> thinned(const std::vector<Vec3f>& positions, double spacing);

// Values of AssetPart::texture for points: the source of their reflectance.
inline constexpr const char* kPointIntensity = "intensity";
inline constexpr const char* kPointColor = "color";

// Reads a file for which isCloud() is true (formats/cloud_file.h). Each point becomes a square with the area of its
// surfel's disc: two triangles, which every method can trace. The points with the same label and instance form a part.
// The part's material and AssetPart::ownClass are the label's name in AssetOptions::points, else in the file, else its
// number. If the options state no names, noise is dropped. The node of instance 7 is "instance 7". The reflectance
// comes from the points' intensities, else from their colours. Throws an InputError that names the file.
Asset readCloudAsset(const std::filesystem::path& file, const AssetOptions& options);

// Reads band 1 of a raster as heights in metres. Each square of four samples becomes two triangles, split along the
// shorter diagonal; a sample without a value leaves a hole. If the raster's coordinates are projected, the asset has
// the same x and y, in metres. If they are longitude and latitude, x and y are metres east and north of the raster's
// middle, and z is the height above the horizontal plane at the middle. AssetOptions::heights can add a class raster:
// the triangles of each class are then a part, whose material is the class number. Otherwise all triangles are one part
// with the material "heights". Throws an InputError that names the file.
Asset readHeightAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
