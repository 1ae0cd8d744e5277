#pragma once

// Drafts a scene file from 3D files: their units, axes, classes and materials are guessed, to be checked by a person.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/ontology.h"
#include "scenefile/concepts.h"

namespace scanmill::draft {

struct DraftedFile {
  std::filesystem::path file;
  std::string name;  // of the object
  double unit = 1;   // m
  char up = 'z';
  std::uint64_t triangles = 0;
  std::uint64_t guessed = 0;        // of them, those that a class was found for, or that are left out
  std::uint64_t byFile = 0;         // of those, the ones that have the class of the file's or its folder's name
  std::vector<std::string> doubts;  // what of it a person should look at, in a few words each
  Box box;                          // m, in its own frame
};

struct Draft {
  std::string yaml;
  std::vector<DraftedFile> files;
  bool onePlace = false;  // the files' own coordinates are kept
};

// One object for each file. Several stand beside one another on the ground, unless they are parts of one place: then
// most are away from the origin of their coordinates, each somewhere else. `folder` is where the scene file will be,
// from which the assets are named, and `ontologyName` what it calls the ontology. Throws InputError for a file that
// cannot be read. `allowOutside`: see AssetOptions.
Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder, bool allowOutside = false);

}  // namespace scanmill::draft
