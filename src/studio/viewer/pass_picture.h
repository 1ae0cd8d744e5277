#pragma once

// Images of passes and of hits, all their planes side by side.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "passes/pass_image.h"
#include "scan/hits.h"
#include "scene/ontology.h"
#include "viewer/coloring.h"
#include "viewer/image.h"

namespace scanmill {

// A picture `width` pixels wide. Depth is coloured by its logarithm, normals by their axes (x red, y green, z blue; 0.5
// is zero), ids each by a colour of its own, looks from 0 to 1 (retroreflectance to its greatest value).
Image drawPasses(const PassImage& image, const Ontology* ontology, int width, const std::string& title);

// The same for hits: a row per ring, the first on top, planes below one another.
Image drawHits(const Hits& hits, const Ontology* ontology, int width, const std::string& title);

// The EXR file of a pass image or of hits, whichever it is. Throws InputError.
Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width);

// A plane of an EXR file, for people who look at one at a time.
struct PassPlane {
  std::string name;                                       // "depth", "semantic"
  Image image;                                            // a pixel per pixel of the file, in the colours of drawExr()
  std::function<std::string(int column, int row)> value;  // "depth: 12.34 m", "semantic: car (6)"; empty outside
  std::string note;                                       // what the colours span; may be empty
  Legend legend;                                          // of classes, materials and shares; else empty
};

// All planes of what drawExr() draws; their values stay readable without the file. `materials`: names by index; those
// that are missing are numbers. Throws InputError as that does.
std::vector<PassPlane> readExrPlanes(const std::filesystem::path& file, const Ontology* ontology,
                                     const std::vector<std::string>& materials = {});

}  // namespace scanmill
