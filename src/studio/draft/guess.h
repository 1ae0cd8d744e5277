#pragma once

// Guesses what an asset is, by its names and its shape.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/asset.h"
#include "scenefile/concepts.h"

namespace scanmill::draft {

// What each part of an asset is, in the order of the parts; null where no word tells. The glass of a car is the car's,
// and a file or folder tells where node, material and texture do not.
std::vector<const Concept*> guessParts(const std::vector<Concept>& concepts, const Asset& asset);

// What the file's own name or its folders' say; null where they say nothing.
const Concept* conceptOfFile(const std::vector<Concept>& concepts, const std::filesystem::path& file);

struct FrameGuess {
  char up = 'z';
  std::string whyUp;  // in words; empty where the file or its kind says it
  bool doubtfulUp = false;
  double unit = 1;  // m
  std::string whyUnit;
  bool doubtfulUnit = false;
  const Concept* what = nullptr;   // what most of it is; null where no word tells, or it is a place of many things
  double longest = 0;              // its longest edge, in its units
  std::array<double, 3> extent{};  // along x, y and z as it was read, in its units
  char read = 'z';                 // the axis that was taken for up then
};

// `asset` was read with the unit 1 and no axis asked for. The unit follows from guessTogether().
FrameGuess guessUp(const Asset& asset, const std::vector<const Concept*>& parts);

// The unit and the axis of files of one kind in one folder: the unit that makes them things of usual sizes, one for all
// where it does so for most of them, and for the tiles among them, whose footprints are alike; and an axis, from the
// others, of those of which nothing tells it.
void guessTogether(const std::vector<FrameGuess*>& files);

// The ground in the file's name, where that says both a ground and a thing ("grass-trees"); null where it does not.
const Concept* groundIn(const std::vector<Concept>& concepts, const std::filesystem::path& file);

// A tile: a plate of ground under what stands on it.
struct Plate {
  const Concept* ground = nullptr;
  double height = 0;  // in the file's units, above its lowest point: what is below is the plate
};

// Where groundIn() finds one, and a level of the asset is as large as it is: the plate. Absent elsewhere. `up`: the
// axis of guessUp().
std::optional<Plate> plateOf(const std::vector<Concept>& concepts, const Asset& asset, char up);

}  // namespace scanmill::draft
