#pragma once

// Lists a single EXR image or the images of a recording, with the names of classes and materials in them.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/recording.h"
#include "scene/ontology.h"

namespace scanmill {

struct ImageList {
  std::string title;                         // name of the folder or file
  std::vector<std::filesystem::path> files;  // paths; not empty
  std::vector<std::string> names;            // file names without suffix
  std::size_t first = 0;                     // index of the image that is shown first
  std::optional<Ontology> ontology;
  std::optional<Recording> recording;  // the recording in the files' folder; absent if there is none

  // Returns the names of the materials in an image by material id; empty if they are unknown.
  std::vector<std::string> materials(std::size_t file) const;
};

// Lists an EXR file, or the images in a recording's folder, sorted by name with numbers in numerical order. `wanted`:
// the image to show first, given by a part of its name or its index starting at 0; empty: the first image. `ontology`:
// replaces the recording's ontology. Throws InputError.
ImageList openImages(const std::filesystem::path& path, const std::string& wanted, std::optional<Ontology> ontology);

}  // namespace scanmill
