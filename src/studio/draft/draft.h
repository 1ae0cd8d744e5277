#pragma once

// Drafts a scene file from 3D files. Their units, axes, classes and materials are guessed; a person must check them.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "draft/model.h"
#include "scene/ontology.h"
#include "scenefile/concepts.h"

namespace scanmill::draft {

struct DraftedFile {
  std::filesystem::path file;
  std::string name;  // name of the object in the scene file
  double unit = 1;   // length of the file's unit (m)
  char up = 'z';
  std::uint64_t triangles = 0;  // triangles, each part counted once
  std::uint64_t trianglesWithCopies = 0;
  // Triangles whose class was guessed from names of node, material, texture or file, or that are guessed to be
  // superfluous.
  std::uint64_t guessed = 0;
  std::uint64_t byFile = 0;         // triangles of `guessed` with the class that the name of the file suggests
  std::uint64_t byFolder = 0;       // other triangles, whose class only the name of the file's folder states
  std::vector<std::string> doubts;  // guesses that a person should check, each in a few words
  Box box;                          // bounding box in the object's frame (m)
};

struct Draft {
  std::string yaml;
  std::vector<DraftedFile> files;
  bool onePlace = false;  // true: the files are parts of one place and keep their coordinates
};

// Drafts a scene with one object per file. If most of the files are away from the origin, at different positions, all
// files count as parts of one place and keep their coordinates. Otherwise several objects are placed side by side on
// the ground. `folder`: future folder of the scene file, to which paths of assets are relative. `ontologyName`: the
// ontology's name in the scene file. `name`: name of the scene. Throws as guessFiles().
Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder, const DraftOptions& options = {});

}  // namespace scanmill::draft
