#pragma once

// Guesses the concepts, up axis and unit of an asset from its names and its shape.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/asset.h"
#include "scenefile/concepts.h"

namespace scanmill::draft {

// Returns the concept of each part of an asset, in the order of the parts; null if no name has a known word. A part
// belongs to the whole that its node names, else to the whole that the file or its folders name: the glass of a car is
// a part of the car. Otherwise the names of material, texture, node and file count, in this order.
std::vector<const Concept*> guessParts(const std::vector<Concept>& concepts, const Asset& asset);

// Returns the concept of the file's own name, else of its folder's or that folder's parent's name; null if none of them
// has a known word.
const Concept* conceptOfFile(const std::vector<Concept>& concepts, const std::filesystem::path& file);

struct FrameGuess {
  char up = 'z';
  std::string whyUp;  // in words; empty if the file or its format states the axis
  bool doubtfulUp = false;
  double unit = 1;  // m
  std::string whyUnit;
  bool doubtfulUnit = false;
  const Concept* what = nullptr;   // the concept of most of the asset; null: unknown, or a place with many objects
  double longest = 0;              // longest edge, in the file's units
  std::array<double, 3> extent{};  // along x, y and z as the file was read, in its units
  char read = 'z';                 // the up axis with which the file was read
};

// Guesses the up axis of an asset that was read with the unit 1 and without a given axis. guessTogether() guesses the
// unit.
FrameGuess guessUp(const Asset& asset, const std::vector<const Concept*>& parts);

// Guesses the units of files of one format in one folder, so that the objects have usual sizes: one unit for all files
// if it suits most of them; else one for the tiles, which are files of about the same footprint, and one for the rest;
// else one for each file. If nothing tells the up axis of a file, takes that of most of the others.
void guessTogether(const std::vector<FrameGuess*>& files);

// Returns the ground in the file's name if the name has both a ground and an object ("grass-trees"), else null.
const Concept* groundIn(const std::vector<Concept>& concepts, const std::filesystem::path& file);

// The plate of ground of a tile, on which other objects stand.
struct Plate {
  const Concept* ground = nullptr;
  double height = 0;  // height of the plate's upper side above the lowest point, in the file's units
};

// Returns the plate of an asset if groundIn() finds a ground and level triangles near the bottom cover most of the
// asset's footprint; else nothing. `up`: the axis of guessUp().
std::optional<Plate> plateOf(const std::vector<Concept>& concepts, const Asset& asset, char up);

}  // namespace scanmill::draft
