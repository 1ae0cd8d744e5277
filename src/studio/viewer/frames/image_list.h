#pragma once

// Lists the EXR images of a recording, or a single image, and what the numbers in them mean.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/recording.h"
#include "scene/ontology.h"

namespace scanmill {

struct ImageList {
  std::string title;                         // the folder's or the file's name
  std::vector<std::filesystem::path> files;  // at least one
  std::vector<std::string> names;            // the names of the files without the suffix
  std::size_t first = 0;                     // index of the file that is shown first
  std::optional<Ontology> ontology;
  std::optional<Recording> recording;  // the recording that the files belong to

  // Returns the names of the materials that a file's numbers stand for, by index; empty if they are unknown.
  std::vector<std::string> materials(std::size_t file) const;
};

// Lists an EXR file, or the images in the folder of a recording, sorted by name with digits compared as numbers.
// `wanted` is a part of the name, or the index from 0, of the image that is shown first; if `wanted` is empty, the
// first image is. `ontology` replaces the recording's. Throws InputError.
ImageList openImages(const std::filesystem::path& path, const std::string& wanted, std::optional<Ontology> ontology);

}  // namespace scanmill
