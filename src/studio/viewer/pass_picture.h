#pragma once

// Draws the planes of EXR files of render passes or of hits, side by side or one at a time.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scene/ontology.h"
#include "viewer/coloring.h"
#include "viewer/image.h"

namespace scanmill {

// A plane of an EXR file.
struct PassPlane {
  std::string name;                                       // "depth", "semantic"
  Image image;                                            // a pixel per pixel of the file
  std::function<std::string(int column, int row)> value;  // "depth: 12.34 m", "semantic: car (6)"; empty outside
  std::string note;                                       // the range of values of the colours; may be empty
  Legend legend;  // legend of classes, materials or shares; empty for other planes
};

// Reads all planes of an EXR file of render passes or of hits; their values stay readable without the file. Depth is
// coloured by its logarithm, normals by their axes (x red, y green, z blue; 0.5 is zero), each id by a colour of its
// own, and material properties from 0 to 1 (retroreflectance from 0 to its greatest value). `materials`: names by
// index; a material without a name is shown by its number. Throws InputError.
std::vector<PassPlane> readExrPlanes(const std::filesystem::path& file, const Ontology* ontology,
                                     const std::vector<std::string>& materials = {});

// Draws all planes of the file in a picture `width` pixels wide. Planes of hits have a row per ring, the first ring on
// top. Throws InputError.
Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width);

}  // namespace scanmill
