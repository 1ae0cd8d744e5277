#pragma once

// Keys of objects whose file is a cloud of points or a raster of heights.

#include "assets/asset.h"
#include "config/value.h"

namespace scanmill {

//   points:
//     spacing: 0.05                  # m: of the points in each cube of a grid one is kept; default: all are
//     neighbors: 12                  # from which normals and radii are estimated
//     cover: 1.5                     # times the radius of a point's share of the surface: more leaves fewer holes
//     radius: [0.005, 0.2]           # m, least and most; or one for all
//     reflectance: auto              # auto (from intensity, else color), intensity, color, none (a plain 0.3)
//     full: 255                      # the intensity of a reflectance of 1; default: 1, 255 or the greatest
//     labels: semantic_kitti         # the ontology whose ids the labels are; points whose class has a name or alias in
//                                    # the scene's ontology have that class where no rule gives another
PointOptions readPointOptions(const Value& value);

//   heights:
//     every: 4                       # so many samples along each axis become one, their mean
//     within: [[x, y], [x, y]]       # least and greatest corner, in the raster's coordinates
//     classes: cover.tif             # numbers of classes: the triangles' materials, for rules
//     image: photo.tif               # colours, for reflectances and rules
HeightOptions readHeightOptions(const Value& value);

// What tells two of them apart.
std::string keyOf(const PointOptions& points, const HeightOptions& heights);

}  // namespace scanmill
