#pragma once

// Lists the EXR images of a recording, or a single one, and what their numbers mean.

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
  std::optional<Recording> recording;  // the recording that they belong to

  // The names of the materials that a file's numbers stand for, by index; empty where they are unknown.
  std::vector<std::string> materials(std::size_t file) const;
};

// Lists an EXR file, or the images in the folder of a recording in the order of their names, where digits count as
// numbers. `wanted` is a part of the name, or the index from 0, of the image that is shown first; where it is empty,
// the first one is. `ontology` stands in place of the recording's. Throws InputError.
ImageList openImages(const std::filesystem::path& path, const std::string& wanted, std::optional<Ontology> ontology);

}  // namespace scanmill
