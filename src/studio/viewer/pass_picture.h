#pragma once

// Images of passes and of hits, all their planes side by side or one at a time.

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
  std::string note;                                       // what the colours span; may be empty
  Legend legend;                                          // of classes, materials and shares; else empty
};

// All planes of the EXR file of a pass image or of hits, whichever it is; their values stay readable without the file.
// Depth is coloured by its logarithm, normals by their axes (x red, y green, z blue; 0.5 is zero), ids each by a colour
// of its own, looks from 0 to 1 (retroreflectance to its greatest value). `materials`: names by index; those that are
// missing are numbers. Throws InputError.
std::vector<PassPlane> readExrPlanes(const std::filesystem::path& file, const Ontology* ontology,
                                     const std::vector<std::string>& materials = {});

// All of them in a picture `width` pixels wide; of hits, a row per ring, the first on top. Throws InputError.
Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width);

}  // namespace scanmill
