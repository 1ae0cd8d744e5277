#pragma once

// 3D files as a draft sees them: names, sizes, and what they are guessed to be.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "draft/guess.h"

namespace scanmill::draft {

// A part of a file by its names, and what it is guessed to be.
struct KnownPart {
  std::string node, material, texture;
  const Concept* what = nullptr;  // null: no word tells
  std::uint64_t triangles = 0;
};

struct Model {
  std::filesystem::path file;
  std::string name;  // that no other of them has
  std::vector<KnownPart> parts;
  const Concept* whole = nullptr;  // by the name of the file or its folders
  FrameGuess frame;
  Box box;                     // m, as it is with the unit and the axis that are guessed
  std::optional<Plate> plate;  // of a tile, of which `whole` stands on the rest
  bool mixed = false;          // the file's name says both a ground and a thing
  bool measured = false;       // the file says what its points reflect
  bool allowOutside = false;   // it was read so: see AssetOptions

  std::uint64_t triangles() const;
  std::uint64_t guessed() const;  // of them, those that a class was found for, or that are left out
  std::uint64_t byFile() const;   // of those, the ones that have the class of the file's or its folder's name
  // What a person should look at, in a few words each.
  std::vector<std::string> doubts() const;
};

// Reads the files. Those of one kind in one folder are guessed together. Throws InputError for a file that cannot be
// read. `allowOutside`: see AssetOptions.
std::vector<Model> readModels(const std::vector<std::filesystem::path>& files, const std::vector<Concept>& concepts,
                              bool allowOutside);

}  // namespace scanmill::draft
