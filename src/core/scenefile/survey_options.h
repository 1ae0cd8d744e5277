#pragma once

// YAML keys of objects whose file is a point cloud or a height raster.

#include "assets/asset.h"
#include "config/value.h"

namespace scanmill {

//   points:
//     spacing: 0.05                  # m, edge of the cubes of a grid: one point in each is kept; default: all
//     neighbors: 12                  # number of points from which a normal and a radius are estimated
//     cover: 1.5                     # factor on the radius of a point's share of the surface: larger, fewer holes
//     radius: [0.005, 0.2]           # m, least and most; or one for all
//     reflectance: auto              # auto (from intensity, else color), intensity, color, none (a plain 0.3)
//     full: 255                      # the intensity that means reflectance 1; default: 1, 255 or the greatest
//     labels: semantic_kitti         # the ontology whose ids the labels are; points whose class the scene's ontology
//                                    # has, by name or alias, keep it unless a rule gives another
PointOptions readPointOptions(const Value& value);

//   heights:
//     every: 4                       # this many samples along each axis are averaged into one
//     within: [[x, y], [x, y]]       # least and greatest corner, in the raster's coordinates
//     classes: cover.tif             # raster of class numbers, which rules can match as material names
//     image: photo.tif               # colours, for reflectances and rules
HeightOptions readHeightOptions(const Value& value);

// Returns a text that is the same for equal options only.
std::string keyOf(const PointOptions& points, const HeightOptions& heights);

}  // namespace scanmill
