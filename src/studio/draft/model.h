#pragma once

// Reads the names and sizes of 3D files, and guesses what they are.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "draft/guess.h"

namespace scanmill::draft {

// A part of a file with its names and its guessed concept.
struct KnownPart {
  std::string node, material, texture;
  const Concept* what = nullptr;  // null: unknown
  std::uint64_t triangles = 0;
};

struct Model {
  std::filesystem::path file;
  std::string name;  // unique among the models
  std::vector<KnownPart> parts;
  const Concept* whole = nullptr;  // from the name of the file or its folders
  FrameGuess frame;
  Box box;                     // m, with the guessed unit and up axis
  std::optional<Plate> plate;  // the plate of a tile; the parts above the plate are `whole`
  bool mixed = false;          // the file's name has both a ground and an object
  bool measured = false;       // the file has measured intensities of points
  bool allowOutside = false;   // as the file was read: see AssetOptions

  std::uint64_t triangles() const;
  std::uint64_t guessed() const;  // triangles whose class was guessed, or that are to be left out
  std::uint64_t byFile() const;   // guessed triangles with the class of the file's or its folder's name
  // Returns the guesses that a person should check, in a few words each.
  std::vector<std::string> doubts() const;
};

// Reads the files. Units and axes of files of one format in one folder are guessed together. `allowOutside`: see
// AssetOptions. Throws InputError for a file that cannot be read.
std::vector<Model> readModels(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                              bool allowOutside);

}  // namespace scanmill::draft
