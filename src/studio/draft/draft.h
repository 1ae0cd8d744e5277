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
  std::string name;  // the name of the object
  double unit = 1;   // m
  char up = 'z';
  std::uint64_t triangles = 0;
  std::uint64_t guessed = 0;        // triangles whose class was guessed, or that are to be left out
  std::uint64_t byFile = 0;         // guessed triangles with the class of the file's or its folder's name
  std::vector<std::string> doubts;  // guesses that a person should check, in a few words each
  Box box;                          // m, in the object's own frame
};

struct Draft {
  std::string yaml;
  std::vector<DraftedFile> files;
  bool onePlace = false;  // the files are parts of one place and keep their coordinates
};

// Drafts a scene with one object for each file. Several objects are placed beside one another on the ground, unless
// they are parts of one place, which is the case if most of them are away from the origin, each somewhere else.
// `folder` is where the scene file will be; the paths of assets are relative to it. `ontologyName` is the ontology's
// name in the scene file. `allowOutside`: see AssetOptions. Throws InputError for a file that cannot be read.
Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder, bool allowOutside = false);

}  // namespace scanmill::draft
