#pragma once

// Draws the planes of EXR files of render passes or hits, side by side or one at a time.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scene/ontology.h"
#include "viewer/coloring.h"
#include "viewer/image.h"

namespace scanmill {

// A plane of an EXR file, such as its depths or its class ids, as an image.
struct PassPlane {
  std::string name;  // quantity in the plane, such as "depth" or "semantic"
  Image image;       // same size as the file's images
  // Returns the value of a pixel as text, such as "12.34 m" or "car (6)"; empty outside of the image.
  std::function<std::string(int column, int row)> value;
  std::string note;  // what the colours show, such as "0 to 1" or "a colour each"; may be empty
  Legend legend;     // names and colours of classes or materials, or the scale of fractions; empty for other planes
};

// Reads all planes of an EXR file of render passes or hits; the file is not needed afterwards. Depth is coloured on a
// logarithmic scale, normals by their components (x red, y green, z blue; 0.5 means zero), ids by one colour each,
// material properties on a scale from 0 to 1 (retroreflectance from 0 to its maximum). `materials`: names by material
// id; materials without a name are shown by id. Throws InputError.
std::vector<PassPlane> readExrPlanes(const std::filesystem::path& file, const Ontology* ontology,
                                     const std::vector<std::string>& materials = {});

// Draws all planes of a file in a picture `width` pixels wide. Planes of hits have one row per ring, with
// ring 0 at the top. Throws InputError.
Image drawExr(const std::filesystem::path& file, const Ontology* ontology, int width);

}  // namespace scanmill
