#pragma once

// Drafts a scene file from 3D files. Their units, axes, classes and materials are guessed; a person must check them.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/vec.h"
#include "draft/guess.h"
#include "scene/ontology.h"

namespace scanmill::draft {

// A part of a file with its names and the concept that was guessed from them.
struct GuessedPart {
  std::string node, material, texture;
  const Concept* shows = nullptr;  // guessed concept; null: unknown
  bool byFolder = false;           // only the name of the file's folder states `shows`
  std::uint64_t triangles = 0;     // triangles of one copy of the part
  std::size_t copies = 1;
};

struct GuessedFile {
  std::filesystem::path file;
  std::string name;  // name of the object in the scene file, unique in it
  std::vector<GuessedPart> parts;
  FileConcept fileConcept;
  FrameGuess frame;
  Box box;                // bounding box (m), computed with the guessed unit and up axis
  bool mixed = false;     // the file's name states both a ground and an object
  bool measured = false;  // no materials are drafted, since the points have intensities or colours
  bool numbered = false;  // the points have labels that are only numbers

  // Returns the number of triangles of the parts for which isCounted(part) is true.
  std::uint64_t trianglesOf(const auto& isCounted) const {
    std::uint64_t sum = 0;
    for (const GuessedPart& part : parts) sum += isCounted(part) ? part.triangles : 0;
    return sum;
  }
  std::uint64_t triangles() const {
    return trianglesOf([](const GuessedPart&) { return true; });
  }
  std::uint64_t trianglesWithCopies() const {
    std::uint64_t sum = 0;
    for (const GuessedPart& part : parts) sum += part.triangles * part.copies;
    return sum;
  }
  // Returns the number of triangles whose concept is stated by a name other than the name of the folder.
  std::uint64_t guessed() const {
    return trianglesOf([](const GuessedPart& part) { return part.shows != nullptr && !part.byFolder; });
  }
  // Returns the number of triangles whose concept the file's name states too. guessed() also counts these triangles.
  std::uint64_t byFile() const {
    if (fileConcept.shown == nullptr || fileConcept.byFolder) return 0;
    return trianglesOf([&](const GuessedPart& part) { return part.shows == fileConcept.shown; });
  }
  // Returns the number of triangles whose concept only the name of the file's folder states.
  std::uint64_t byFolder() const {
    return trianglesOf([](const GuessedPart& part) { return part.byFolder; });
  }
  // Returns the guesses that a person should check, in a few words each.
  std::vector<std::string> doubts() const;
};

struct DraftOptions {
  bool allowOutside = false;                  // see AssetOptions
  bool leaveOutMissing = false;               // see AssetOptions
  std::set<std::filesystem::path> mayFail{};  // files that are left out with a warning if they cannot be read
};

struct Draft {
  std::string yaml;
  std::vector<GuessedFile> files;
  bool onePlace = false;            // true: the files are parts of one place and keep their coordinates
  std::vector<Concept> concepts{};  // the concepts that `files` point to
};

// Drafts a scene with one object per file. If most of the files are away from the origin, at different positions, all
// files count as parts of one place and keep their coordinates. Otherwise several objects are placed side by side on
// the ground. `folder`: future folder of the scene file, to which paths of assets are relative. `ontologyName`: the
// ontology's name in the scene file. `name`: name of the scene. Throws InputError like guessFiles().
Draft draftScene(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                 const Ontology& ontology, const std::string& ontologyName, const std::string& name,
                 const std::filesystem::path& folder, const DraftOptions& options = {});

// Reads 3D files and guesses their concepts, units and axes. The units and axes of files with the same format and
// folder are guessed together. Throws InputError if no file can be read, or if a file that is not in options.mayFail
// cannot be read.
std::vector<GuessedFile> guessFiles(const std::vector<std::filesystem::path>& files,
                                    const std::vector<Concept>& concepts, const DraftOptions& options);

// Returns the concepts that have a class in the ontology, and those that need no class, such as parts to be removed.
// Example: if an ontology for rooms has no class for buildings, "office.glb" is not taken for a building. The names of
// the ontology's classes are added as words.
std::vector<Concept> conceptsFor(const std::vector<Concept>& concepts, const Ontology& ontology);

// Returns an object as YAML, without its position. `folder`: folder of the scene file, to which paths are relative.
std::string objectYaml(const GuessedFile& model, const std::vector<Concept>& concepts, const Ontology& ontology,
                       const std::filesystem::path& folder, const DraftOptions& options);

}  // namespace scanmill::draft
