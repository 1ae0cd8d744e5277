#pragma once

// Images of passes and of hits, all their planes side by side.

#include <filesystem>
#include <string>

#include "passes/pass_image.h"
#include "scan/hits.h"
#include "scene/ontology.h"
#include "viewer/image.h"

namespace scanmill {

// A picture `width` pixels wide. Depth is coloured by its logarithm, normals by their axes (x red, y green, z blue; 0.5
// is zero), ids each by a colour of its own, looks from 0 to 1 (retroreflectance to its greatest value).
Image drawPasses(const PassImage& image, const Ontology* ontology, int width, const std::string& title);

// The same for hits: a row per ring, the first on top, planes below one another.
Image drawHits(const Hits& hits, const Ontology* ontology, int width, const std::string& title);

// The EXR file of a pass image or of hits, whichever it is. Throws InputError.
Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width);

}  // namespace scanmill
