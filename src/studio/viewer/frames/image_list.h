#pragma once

// The EXR images of a recording, or one alone, and what their numbers mean.

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
  std::vector<std::string> names;            // of the files, without the suffix
  std::size_t first = 0;                     // that is shown first
  std::optional<Ontology> ontology;
  std::optional<Recording> recording;  // that they lie in

  // Names of the materials that a file points to, by index; empty where unknown.
  std::vector<std::string> materials(std::size_t file) const;
};

// An EXR file, or the folder of a recording: its images in the order of their names, numbers by their value. `wanted`:
// a part of a name, or an index from 0; empty: the first. `ontology`: in place of the recording's. Throws InputError.
ImageList openImages(const std::filesystem::path& path, const std::string& wanted, std::optional<Ontology> ontology);

}  // namespace scanmill
