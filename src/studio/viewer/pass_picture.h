#pragma once

// Draws the planes of EXR files of render passes or hits.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/ontology.h"
#include "viewer/image.h"

namespace scanmill {

// An EXR file, with what its recording says about it.
struct ExrSource {
  std::filesystem::path file;
  std::optional<Ontology> ontology{};    // absent: the names and colours of classes are unknown
  std::vector<std::string> materials{};  // names by material id; materials without a name are shown by id
};

// Returns an EXR file, or the image of the recording in a folder that `wanted` specifies, see findKey(); images are in
// the order of their names, with numbers in numerical order. Throws InputError.
ExrSource findExr(const std::filesystem::path& path, const std::string& wanted);

// Draws the plane with this name and its legend beside it or, if `plane` is empty, all planes side by side, in a
// picture `width` pixels wide. Depth is coloured on a logarithmic scale, normals by their components (x red, y green, z
// blue; 0.5 means zero), ids by one colour each, material properties on a scale from 0 to 1 (retroreflectance from 0 to
// its maximum). Planes of hits have one row per ring, with ring 0 at the top. Throws InputError.
Image drawExr(const ExrSource& source, const std::string& plane, int width);

}  // namespace scanmill
