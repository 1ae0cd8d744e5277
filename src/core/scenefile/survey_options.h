#pragma once

// YAML keys of objects whose file is a point cloud or a height raster.

#include "assets/asset.h"
#include "config/value.h"

namespace scanmill {

// Reads the options of a point cloud:
//
//   points:
//     spacing: 0.05                  # m, edge of the cubes of a grid: one point per cube is kept; default: keep all
//     neighbors: 12                  # number of points from which a normal and a radius are estimated
//     cover: 1.5                     # factor on the radius of the disc that replaces a point; larger: fewer holes
//     radius: [0.005, 0.2]           # m, smallest and largest radius of a disc; or one radius for all
//     reflectance: auto              # auto (from intensity, else color), intensity, color, none (a plain 0.3)
//     full: 255                      # the intensity with reflectance 1; default: 1, 255 or the greatest but for
//     outliers labels: semantic_kitti         # the ontology of the points' labels. If the scene's ontology has a
//     point's class,
//                                    # by name or alias, the point keeps the class unless a rule sets another one
PointOptions readPointOptions(const Value& value);

// Reads the options of a height raster:
//
//   heights:
//     every: 4                       # this many samples along each axis are averaged into one
//     within: [[x, y], [x, y]]       # least and greatest corner, in the raster's coordinates
//     classes: cover.tif             # raster of class numbers, which rules can match as material names
//     image: photo.tif               # colours, for reflectances and rules
HeightOptions readHeightOptions(const Value& value);

// Returns a key for comparison: two keys are equal only if all options are equal.
std::string keyOf(const PointOptions& points, const HeightOptions& heights);

}  // namespace scanmill
